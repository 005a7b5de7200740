# SPDX-License-Identifier: Apache-2.0
"""What two motions are to each other: correlation at every lag."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.relation import MOST_GAPS, MOST_POINTS, Comparison, _grid


def bump(time_s: np.ndarray, at: float) -> np.ndarray:
    return np.exp(-np.square((time_s - at) / 0.3))


@pytest.mark.parametrize("points", [1023, 1024, 1025, 1100])
def test_the_end_of_one_sensor_is_not_compared_with_the_start_of_the_other(points: int) -> None:
    time_s = 0.1 * np.arange(points + 1)
    s1, s2 = bump(time_s, time_s[-1] - 1.5), bump(time_s, 1.5)
    found = Comparison(Motion(time_s, s1), Motion(time_s, s2)).relations
    assert max((each.correlation for each in found), default=0.0) < 0.1


@pytest.mark.parametrize("jump_s", [1e3, 10 * 365.25 * 86400.0, 2e9])
def test_work_grows_with_samples_not_with_time(jump_s: float) -> None:
    time_s = 1e-3 * np.arange(4000)
    apart = time_s + np.where(time_s < 1.0, 0.0, jump_s)
    rng = np.random.default_rng(3)
    signal = np.cumsum(np.cumsum(rng.standard_normal(time_s.size)))
    s1, s2 = Motion(apart, -signal), Motion(apart[::10], signal[::10])
    grid = _grid(s1, s2, MOST_POINTS)
    assert grid is not None
    assert grid.s1.size <= MOST_GAPS * time_s.size
    best = Comparison(s1, s2).relations[0]
    assert best.sign == -1
    assert best.correlation > 0.9
