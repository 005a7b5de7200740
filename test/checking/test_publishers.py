# SPDX-License-Identifier: Apache-2.0
"""Two sensors that publish on one topic."""

from __future__ import annotations

import numpy as np
import pytest
from checking.made import both, only, sensor
from checking.standins import MOTIONS, pair

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.finding import Level

T1: Reals = 0.01 * np.arange(6000)
T2: Reals = 0.1 * np.arange(600)
NOISE: Reals = np.random.default_rng(1).normal(size=6000)
IN_TURN: Reals = np.where(np.arange(6000) % 2 == 0, 0.5, -0.5)


def motion(time_s: Reals) -> Reals:
    """Two sines that have nothing in common."""
    found: Reals = np.sin(time_s) + np.sin(2.3 * time_s + 1.0)
    return found


def checked(s1: Reals, frames: tuple[str, ...] = ("imu",)) -> Check:
    return both(sensor("s1", T1, s1)._replace(frames=frames), sensor("s2", T2, motion(T2)))


def test_values_of_two_sensors_in_turn_are_named() -> None:
    finding = only(checked(motion(T1) + IN_TURN + 0.1 * NOISE).findings, "publishers")
    assert finding.level is Level.WARNING
    assert finding.text == "values of s1 alternate by 1, as those of two sensors on one topic do"
    assert finding.remedy == "keep only one publisher on its topic"


@pytest.mark.parametrize("noise", [0.0, 0.1, 1.0, 10.0])
def test_noise_does_not_alternate(noise: float) -> None:
    found = checked(motion(T1) + noise * NOISE)
    assert "publishers" not in {each.about for each in found.findings}


@pytest.mark.parametrize("name", MOTIONS)
def test_no_motion_alternates(name: str) -> None:
    for seed in range(5):
        for fault in ("none", "exchanged", "s1 is the rate"):
            found = check(pair(name, fault, seed).sensors(), 2048)
            assert "publishers" not in {each.about for each in found.findings}


def test_frames_in_turn_are_named() -> None:
    finding = only(checked(motion(T1), ("left", "right") * 4).findings, "publishers")
    assert finding.level is Level.WARNING
    assert finding.text == "messages of s1 alternate between frame_ids: 'left', 'right'"
    many = only(checked(motion(T1), (*"abcde", *"abcde")).findings, "publishers")
    assert many.text.endswith("'a', 'b', 'c' and 2 more")


@pytest.mark.parametrize(
    "frames",
    [("", "imu"), ("", "imu", "", "imu"), ("imu", "imu_link", "imu"), ("", "imu") * 3],
)
def test_frames_of_a_driver_that_restarts_do_not_alternate(frames: tuple[str, ...]) -> None:
    assert checked(motion(T1), frames).is_fine
