# SPDX-License-Identifier: Apache-2.0
"""S2's lag, found by what S1 shows behind many lags at a time."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.smoothing import lagged
from fuzzy_fusion_ros.self_tuning.allan import Octaves, Reals, counted, no_octaves
from fuzzy_fusion_ros.self_tuning.choice import NO_LAG
from fuzzy_fusion_ros.self_tuning.lag_bank import (
    FoundLag,
    LagBank,
    found_lag,
    lag_bank,
    passed,
)

DT, EVERY = 0.05, 5
BEFORE = FoundLag(7, 0.4, 0.2)


def compared(s1: Reals, s2: Reals, noise: float = 0.0) -> tuple[LagBank, Octaves]:
    """Run the bank over S1 and compare it with every fifth sample of S2."""
    generator = np.random.default_rng(6)
    bank = lag_bank(EVERY * DT, float(s1[0]))
    errors = no_octaves(8, bank.lags.size + 1)
    for k, (one, other) in enumerate(zip(s1, s2, strict=True)):
        bank = passed(bank, DT, float(one))
        if k % EVERY == 0:
            value = float(other) + noise * generator.standard_normal()
            errors = counted(errors, np.append(bank.second, 0.0) - value, False, 512)
    return bank, errors


def swings(seconds: float = 100.0) -> tuple[Reals, Reals]:
    time_s = np.arange(0.0, seconds, DT)
    return time_s, np.sin(0.9 * time_s) + 0.4 * np.sin(2.3 * time_s + 1.0)


def test_the_bank_is_two_lags_in_a_row() -> None:
    time_s, s1 = swings(5.0)
    bank = lag_bank(0.25, float(s1[0]))
    for before, after, value in zip(time_s, time_s[1:], s1[1:], strict=False):
        bank = passed(bank, after - before, float(value))
    for k, (lag, delay) in enumerate(zip(bank.lags, bank.delays, strict=True)):
        behind = lagged(time_s, lagged(time_s, s1, float(lag)), float(delay))
        assert bank.second[k] == pytest.approx(behind[-1], abs=1e-9)
    assert bank.second[0] == s1[-1]


@pytest.mark.parametrize(("lag", "delay"), [(0.5, 0.0), (0.3, 0.3), (1.2, 0.0), (0.15, 0.15)])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_s2s_lag_is_found(lag: float, delay: float, noise: float) -> None:
    time_s, s1 = swings()
    s2 = lagged(time_s, lagged(time_s, s1, lag), delay) - 0.3
    bank, errors = compared(s1 + 0.001 * time_s, s2, noise)
    found = found_lag(bank, errors, time_s[-1], 0.0, BEFORE)
    assert found.lag + found.delay == pytest.approx(lag + delay, rel=0.12)


def test_without_motion_the_answer_stays() -> None:
    bank, errors = compared(np.zeros(2000), np.zeros(2000), noise=0.1)
    assert found_lag(bank, errors, 100.0, 0.0, BEFORE) == BEFORE


def test_unrelated_sensors_have_no_lag() -> None:
    time_s, s1 = swings()
    bank, errors = compared(s1, np.cos(0.37 * time_s))
    assert found_lag(bank, errors, time_s[-1], 0.0, NO_LAG) == NO_LAG


def test_a_lag_needs_a_span_much_longer_than_itself() -> None:
    time_s, s1 = swings(20.0)
    bank, errors = compared(s1, lagged(time_s, s1, 2.0))
    assert found_lag(bank, errors, time_s[-1], 0.0, BEFORE) == BEFORE


def test_what_s2_comes_late_is_no_lag() -> None:
    time_s, s1 = swings()
    late = 0.2
    bank, errors = compared(s1, np.interp(time_s - late, time_s, lagged(time_s, s1, 0.4)))
    found = found_lag(bank, errors, time_s[-1], late, BEFORE)
    assert found.lag + found.delay == pytest.approx(0.4, rel=0.12)
