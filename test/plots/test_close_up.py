# SPDX-License-Identifier: Apache-2.0
"""Which stretch is shown closer."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.plots.close_up import close_up

TIME_S = np.arange(1000) * 0.1


def test_it_is_where_the_signal_varies_most() -> None:
    truth = np.where((TIME_S > 40.0) & (TIME_S < 42.0), 1.0, 0.0)
    near = close_up(TIME_S, truth, TIME_S)
    assert TIME_S[near][0] <= 41.0 <= TIME_S[near][-1]
    assert np.ptp(TIME_S[near]) < 6.0


def test_noise_is_not_mistaken_for_motion() -> None:
    noise = 0.02 * np.random.default_rng(0).standard_normal(1000)
    truth = noise + np.where(TIME_S > 70.0, 0.0, 0.0) + np.exp(-TIME_S)
    assert close_up(TIME_S, truth, TIME_S)[:10].all()


def test_a_slow_s2_widens_it() -> None:
    near = close_up(TIME_S, TIME_S, np.floor(TIME_S / 4.0))
    assert np.ptp(TIME_S[near]) > 50.0


def test_what_is_unknown_does_not_vary() -> None:
    truth = np.where(TIME_S < 50.0, np.nan, np.sin(TIME_S))
    near = close_up(TIME_S, truth, TIME_S)
    assert np.isfinite(truth[near]).all()
    assert close_up(TIME_S[:2], truth[-2:], truth[-2:]).all()
