# SPDX-License-Identifier: Apache-2.0
"""Where the direction of a vector means nothing."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.direction import meaningless

TURN = 2.0 * math.pi
TIMES: Reals = np.arange(300.0)
RESTS = (TIMES >= 100.0) & (TIMES < 140.0)
SPEED: Reals = np.where(RESTS, 0.01, 8.0)
DRIVEN: Reals = np.cumsum(np.where(RESTS, 0.0, 0.1 * np.sin(0.05 * TIMES)))
RANDOM: Reals = np.random.default_rng(1).uniform(-math.pi, math.pi, TIMES.size)


def wrapped(angles: Reals) -> Reals:
    found: Reals = angles - TURN * np.round(angles / TURN)
    return found


@pytest.mark.parametrize("turned", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("turn", [TURN, 360.0])
def test_a_course_means_nothing_at_standstill(turned: float, turn: float) -> None:
    course = wrapped(DRIVEN + turned + np.where(RESTS, RANDOM, 0.0))
    found = meaningless(course * turn / TURN, SPEED, turn)
    np.testing.assert_array_equal(found, RESTS)


@pytest.mark.parametrize(
    "heading",
    [
        wrapped(DRIVEN + np.where(RESTS, 0.5 * (TIMES - 100.0), 0.0)),  # turns on the spot
        DRIVEN + 0.001 * RANDOM,  # holds at standstill
        DRIVEN + RANDOM,  # as random in motion
        np.where(RESTS, math.nan, DRIVEN),  # withheld
    ],
)
def test_a_heading_that_does_not_scatter_at_standstill_means_something(heading: Reals) -> None:
    assert not meaningless(heading, SPEED, TURN).any()


@pytest.mark.parametrize(
    "speed",
    [
        np.full(TIMES.size, 8.0),
        np.full(TIMES.size, math.nan),
        np.zeros(TIMES.size),
        np.where(TIMES == 120.0, 0.01, 8.0),
    ],
)
def test_without_a_standstill_a_course_means_something(speed: Reals) -> None:
    course = wrapped(DRIVEN + np.where(RESTS, RANDOM, 0.0))
    assert not meaningless(course, speed, TURN).any()
