# SPDX-License-Identifier: Apache-2.0
"""The one-pass smoother is the weighted mean, or line, that its docstring tells."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.smoothing import lagged, smoothed


def slowly(
    time_s: Reals, values: Reals, time_constant: float, straight: bool, hole: float
) -> Reals:
    """Smooth sample by sample, over all others."""
    found = values.copy()
    for k, now in enumerate(time_s):
        away = time_s - now
        counted = np.abs(away) > hole
        if not counted.any():
            continue
        nearest = np.abs(away[counted]).min()
        weights = np.exp(-(np.abs(away[counted]) - nearest) / time_constant)
        line = np.polyfit(away[counted], values[counted], 1, w=np.sqrt(weights)) if straight else []
        found[k] = line[1] if straight else np.average(values[counted], weights=weights)
    return found


@pytest.mark.parametrize("straight", [False, True])
@pytest.mark.parametrize("hole", [-1.0, 0.0, 0.7])
@pytest.mark.parametrize("time_constant", [0.3, 2.0])
def test_it_is_what_a_slow_one_gives(straight: bool, hole: float, time_constant: float) -> None:
    generator = np.random.default_rng(3)
    time_s = np.cumsum(generator.uniform(0.05, 0.4, 60))
    values = generator.standard_normal(60) + time_s
    fast = smoothed(time_s, values, time_constant, straight, hole)
    assert fast == pytest.approx(slowly(time_s, values, time_constant, straight, hole), abs=1e-6)


def test_a_hole_that_takes_all_leaves_the_sample() -> None:
    time_s = np.array([0.0, 1.0, 2.0])
    values = np.array([3.0, -1.0, 5.0])
    assert smoothed(time_s, values, 1.0, True, 10.0).tolist() == [3.0, -1.0, 5.0]


def test_a_long_gap_does_not_underflow() -> None:
    time_s = np.array([0.0, 0.1, 1e6, 1e6 + 0.1])
    values = np.array([1.0, 1.0, 2.0, 2.0])
    assert smoothed(time_s, values, 0.01).tolist() == [1.0, 1.0, 2.0, 2.0]
    assert np.isfinite(smoothed(time_s, values, 0.01, True, 0.5)).all()


def test_a_lag_reaches_63_percent_in_its_time_constant() -> None:
    time_s = np.linspace(0.0, 1.0, 101)
    step = np.where(time_s > 0.0, 1.0, 0.0)
    assert lagged(time_s, step, 1.0)[-1] == pytest.approx(1.0 - np.exp(-1.0))
    assert lagged(time_s, step, 0.0).tolist() == step.tolist()
