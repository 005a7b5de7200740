# SPDX-License-Identifier: Apache-2.0
"""Clocks of two sensors that are apart: from when on that is said."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.online.clocks import clock_problem
from fuzzy_fusion_ros.online.guard import DELAYS, FEWEST_DELAYS, Guard


def arriving(delay: float) -> Guard:
    """Return a guard whose samples arrive this long after their stamps, seconds."""
    guard = Guard()
    guard.delays_ns.extend([round(delay * 1e9)] * FEWEST_DELAYS)
    return guard


@pytest.mark.parametrize(
    ("s1", "s2", "said"),
    [
        (0.01, 0.01, ""),
        (0.0, 0.2, ""),  # what transport does
        (0.0, 1.5, ""),  # a slow sensor
        (0.0, 2.5, "s2's stamps are 2.5 s behind s1's although both arrive together: "),
        (2.5, 0.0, "s2's stamps are 2.5 s ahead of s1's although both arrive together: "),
        (
            0.0,
            -0.5,
            "s2's stamps are 0.5 s ahead of s1's although both arrive together: ",
        ),  # before its time
        (-0.5, 0.0, "s2's stamps are 0.5 s behind s1's although both arrive together: "),
        (
            1.5,
            0.0,
            "s2's stamps are 1.5 s ahead of s1's although both arrive together: ",
        ),  # past S1's timeout
    ],
)
def test_what_does_harm_is_said(s1: float, s2: float, said: str) -> None:
    problem = clock_problem(arriving(s1), arriving(s2), 1.0, 5.0)
    assert problem.startswith(said)
    assert bool(problem) == bool(said)


def test_nothing_is_said_before_enough_samples_have_come() -> None:
    few = Guard()
    few.delays_ns.extend([10**10] * (FEWEST_DELAYS - 1))
    assert clock_problem(few, arriving(0.0), 1.0, 5.0) == ""
    assert clock_problem(arriving(0.0), few, 1.0, 5.0) == ""


def test_a_late_sensor_is_told_which_timeout_to_set() -> None:
    late = "; if the messages of s2 are late, set s2.timeout: 0.0"
    assert clock_problem(arriving(0.0), arriving(0.8), 1.0, 0.5).endswith(late)
    assert late not in clock_problem(arriving(0.0), arriving(5.0), 1.0, 0.5)  # not even then
    assert late not in clock_problem(arriving(-0.5), arriving(0.3), 1.0, 0.5)


def test_delays_that_grow_are_no_offset() -> None:
    """At three times its rate a recording's stamps outrun the clock, and S2 is sampled longer."""
    s1, s2 = Guard(), Guard()
    for k in range(3200):
        s1.delays_ns.append(-round(k * 0.01 * 2.0 / 3.0 * 1e9))
        if k % 100 == 0:
            s2.delays_ns.append(-round(k * 0.01 * 2.0 / 3.0 * 1e9))
    assert s1.delay is not None
    assert s2.delay is not None
    assert s2.delay - s1.delay > 5.0
    assert clock_problem(s1, s2, 1.0, 5.0) == ""


@pytest.mark.parametrize("samples", [3, 4, 10, 32])
@pytest.mark.parametrize("speed", [0.3, 3.0])
def test_delays_that_grow_are_no_offset_with_few_samples_either(speed: float, samples: int) -> None:
    s1, s2 = Guard(), Guard()
    for k in range(100 * samples):
        delay_ns = round(k * 0.01 * (1.0 / speed - 1.0) * 1e9)
        s1.delays_ns.append(delay_ns)
        if k % 100 == 0:
            s2.delays_ns.append(delay_ns)
    assert clock_problem(s1, s2, 0.1, 0.1) == ""


def test_jitter_on_a_real_offset_still_warns() -> None:
    """Delivery takes up to 0.5 s more or less than the 1.9 s by which S2's clock is behind."""
    rng = np.random.default_rng(5)
    s1, s2 = arriving(0.0), Guard()
    for _ in range(200):
        s2.delays_ns.append(round(rng.uniform(1.4, 2.4) * 1e9))
        if len(s2.delays_ns) == DELAYS:
            assert clock_problem(s1, s2, 1.0, 1.0).startswith("s2's stamps are ")
