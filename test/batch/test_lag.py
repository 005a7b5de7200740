# SPDX-License-Identifier: Apache-2.0
"""S2's lag behind S1 is found, whatever its shape, and chance is told from a relation."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.lag import TRUSTED, Lag, chance_correlation, lag_of, read_through
from fuzzy_fusion_ros.batch.smoothing import lagged

S1_S = np.arange(0.0, 120.0, 0.02)


def motion(seed: int = 0) -> Reals:
    """Return a signal that wanders within seconds."""
    white = np.random.default_rng(seed).normal(0.0, 2.0, S1_S.size)
    return lagged(S1_S, lagged(S1_S, white, 1.0), 0.3)


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.8])
@pytest.mark.parametrize("time_constant", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("interval", [0.02, 0.2])
def test_it_is_found(delay: float, time_constant: float, interval: float) -> None:
    s1, s2_s = motion(), np.arange(1.0, 119.0, interval)
    s2 = read_through(Lag(delay, time_constant, 1.0), S1_S, s1, s2_s)
    found = lag_of(S1_S, s1 + 0.3, s2_s, s2)
    assert found.total == pytest.approx(delay + time_constant, abs=0.02, rel=0.03)
    assert found.correlation > 0.99


def test_a_second_order_lag_counts_with_both_its_time_constants() -> None:
    s1, s2_s = motion(), np.arange(1.0, 119.0, 0.1)
    s2 = np.interp(s2_s, S1_S, lagged(S1_S, lagged(S1_S, s1, 0.4), 0.4))
    assert lag_of(S1_S, s1, s2_s, s2).total == pytest.approx(0.8, abs=0.08)


@pytest.mark.parametrize(("size", "apart"), [(2, 0.005), (2, 0.04), (5, 0.001)])
def test_bursts_of_s2_do_not_hide_it(size: int, apart: float) -> None:
    s2_s = np.add.outer(np.arange(1.0, 118.0, 0.5), apart * np.arange(size)).ravel()
    noise = 0.01 * np.random.default_rng(1).standard_normal(s2_s.size)
    s2 = read_through(Lag(0.4, 0.0, 1.0), S1_S, motion(), s2_s) + noise
    found = lag_of(S1_S, motion(), s2_s, s2)
    assert found.total == pytest.approx(0.4, abs=0.02)
    assert found.correlation > 0.99


def test_wild_samples_of_s2_do_not_hide_it() -> None:
    s1, s2_s = motion(), np.arange(1.0, 119.0, 0.2)
    generator = np.random.default_rng(1)
    wild = 8.0 * generator.standard_normal(s2_s.size) * (generator.random(s2_s.size) < 0.03)
    s2 = read_through(Lag(0.4, 0.0, 1.0), S1_S, s1, s2_s) + wild
    assert lag_of(S1_S, s1, s2_s, s2).total == pytest.approx(0.4, abs=0.1)


def test_unrelated_sensors_correlate_as_chance_has_it() -> None:
    s2_s = np.arange(1.0, 119.0, 0.2)
    s2 = np.interp(s2_s, S1_S, motion(seed=1))
    lag = lag_of(S1_S, motion(), s2_s, s2)
    assert lag.correlation <= chance_correlation(S1_S, motion(), s2_s, s2) < TRUSTED


def test_sensors_that_do_not_overlap_have_none() -> None:
    s2_s = np.arange(1000.0, 1100.0, 0.2)
    assert lag_of(S1_S, motion(), s2_s, np.sin(s2_s)) == Lag(0.0, 0.0, 0.0)
