# SPDX-License-Identifier: Apache-2.0
"""Adaptation of S2's lag and of S1's scale: what it follows, when it rests, what it cannot do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.adaptation import LARGEST_LAG, LARGEST_SCALE, Adaptation
from fuzzy_fusion_ros.core.estimator import State, initial_state, observe_s2, update
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000
STEP = 20_000_000

OBSERVER = replace(
    Parameters(),
    {
        "aggregator.difference.small": 1e8,
        "aggregator.difference.large": 1e9,
        **{f"aggregator.weight.{e}": 0.0 for e in ("very_small", "small", "large", "very_large")},
        "s1.bias_time_constant": 3.0,
        "s1.bias_prior": 1.0,
        "s2.noise": 0.01,
        "s2.lag_time_constant": 0.4,
        "s2.delay": 0.1,
    },
)
ADAPTING = replace(OBSERVER, {"adapt.lag_time_constant": 5.0, "adapt.scale_time_constant": 10.0})

TIME_S = np.arange(5000) * 0.02

SEEDS = pytest.mark.parametrize(
    "seed", [0, *(pytest.param(k, marks=pytest.mark.slow("more seeds")) for k in (1, 2))]
)


def swings(seed: int = 0) -> list[float]:
    """Return a signal of two frequencies, in turns at rest and in motion."""
    phase = np.random.default_rng(seed).uniform(0.0, 6.0)
    moving = np.sin(0.25 * TIME_S) > -0.3
    signal = np.sin(1.3 * TIME_S + phase) + 0.5 * np.sin(2.9 * TIME_S)
    return through(np.where(moving, signal, 0.0).tolist(), [0.2] * TIME_S.size)


def through(signal: list[float], lags_s: list[float]) -> list[float]:
    """Return a signal behind a first-order lag that may change, sampled at 50 Hz."""
    seen, found = signal[0], []
    for x, lag in zip(signal, lags_s, strict=True):
        seen += (1.0 - math.exp(-0.02 / lag)) * (x - seen)
        found.append(seen)
    return found


def run(
    parameters: Parameters, s1: list[float], s2: list[float], state: State | None = None
) -> tuple[list[float], list[Adaptation], State]:
    """Return estimates and what is adapted at each sample of S1; S2 comes with every tenth."""
    state = state or initial_state(parameters)
    start_ns = state.sensors.s1.stamp_ns + SECOND
    values, adapted = [], []
    for k, (fast, slow) in enumerate(zip(s1, s2, strict=True)):
        stamp_ns = start_ns + k * STEP
        if k % 10 == 0 and math.isfinite(slow):
            state = observe_s2(parameters, state, stamp_ns, slow)
        estimate, state = update(parameters, state, stamp_ns, fast)
        values.append(estimate.value)
        adapted.append(state.sensors.belief.adaptation)
    return values, adapted, state


def sensors(
    seed: int, scale: float = 1.0, later: float = 1.0
) -> tuple[list[float], list[float], list[float]]:
    """Return the truth, S1 and S2; S2's lag is ``later`` times as long in the second half."""
    generator = np.random.default_rng(seed)
    truth = swings(seed)
    s1 = scale * np.array(truth) + 0.3 + generator.normal(0.0, 0.05, TIME_S.size)
    longer = np.where(TIME_S < 50.0, 1.0, later)
    lagged = through(truth, (0.4 * longer).tolist())
    late = np.interp(TIME_S - 0.1 * longer, TIME_S, lagged)
    return truth, s1.tolist(), (late + generator.normal(0.0, 0.01, TIME_S.size)).tolist()


def error(values: list[float], truth: list[float]) -> float:
    """Return the root mean square error of the last quarter."""
    return float(np.sqrt(np.mean(np.square(np.subtract(values, truth)[-TIME_S.size // 4 :]))))


@SEEDS
def test_a_lag_that_trebles_is_followed(seed: int) -> None:
    truth, s1, s2 = sensors(seed, later=3.0)
    values, adapted, _ = run(replace(ADAPTING, {"adapt.scale_time_constant": 0.0}), s1, s2)
    still, _, _ = run(OBSERVER, s1, s2)
    assert adapted[TIME_S.size // 2 - 1].lag.value == pytest.approx(1.0, abs=0.1)
    assert adapted[-1].lag.value == pytest.approx(3.0, rel=0.15)
    assert error(values, truth) < 0.06  # of which S1's noise is 0.05
    assert error(still, truth) > 1.5 * error(values, truth)
    _, both, _ = run(ADAPTING, s1, s2)
    assert both[-1].lag.value == pytest.approx(3.0, rel=0.15)
    assert both[-1].scale.value == pytest.approx(1.0, abs=0.15)


@SEEDS
@pytest.mark.parametrize("scale", [0.7, 1.3])
def test_a_scale_that_is_off_is_found(seed: int, scale: float) -> None:
    truth, s1, s2 = sensors(seed, scale)
    values, adapted, _ = run(ADAPTING, s1, s2)
    still, _, _ = run(OBSERVER, s1, s2)
    assert adapted[-1].scale.value == pytest.approx(1.0 / scale, rel=0.05)
    assert adapted[-1].lag.value == pytest.approx(1.0, abs=0.1)
    assert error(values, truth) < 0.05 / scale + 0.02
    assert error(still, truth) > 2.0 * error(values, truth)


def test_only_what_is_asked_for_is_adapted() -> None:
    _, s1, s2 = sensors(0, scale=1.3, later=3.0)
    for name, other in (("lag", "scale"), ("scale", "lag")):
        _, adapted, _ = run(replace(OBSERVER, {f"adapt.{name}_time_constant": 5.0}), s1, s2)
        assert getattr(adapted[-1], name).value != 1.0
        assert {getattr(each, other).value for each in adapted} == {1.0}
    _, adapted, _ = run(OBSERVER, s1, s2)
    assert {each.lag.value for each in adapted} == {each.scale.value for each in adapted} == {1.0}


def test_hardly_anything_moves_while_the_signal_rests() -> None:
    """S1's noise rarely shows so far behind S2's lag as a change of a factor would."""
    _, s1, s2 = sensors(0, scale=1.1)
    _, _, state = run(ADAPTING, s1, s2)
    generator = np.random.default_rng(1)
    rest = (0.3 + generator.normal(0.0, 0.05, 6000)).tolist()
    slow = generator.normal(0.0, 0.01, 6000).tolist()
    _, adapted, _ = run(ADAPTING, rest, slow, state)
    for number in (0, 1):
        factors = np.array([each[number].value for each in adapted[1000:]])
        assert np.ptp(factors) < 0.01


def test_nothing_moves_while_s2_is_silent() -> None:
    _, s1, s2 = sensors(0, scale=1.1)
    _, _, state = run(ADAPTING, s1, s2)
    before = state.sensors.belief.adaptation
    _, adapted, _ = run(ADAPTING, s1, [math.nan] * len(s1), state)
    assert adapted[-1].lag[:3] == (True, *before.lag[1:3])
    assert adapted[-1].scale[:3] == (True, *before.scale[1:3])


def test_what_is_switched_off_stays_as_it_is_and_goes_on_from_there() -> None:
    _, s1, s2 = sensors(0, scale=1.3)
    _, _, state = run(ADAPTING, s1, s2)
    found = state.sensors.belief.adaptation.scale.value
    _, adapted, state = run(OBSERVER, s1, s2, state)
    assert {each.scale.value for each in adapted} == {found}
    _, adapted, _ = run(ADAPTING, s1, s2, state)
    assert adapted[0].scale.value == found
    assert adapted[-1].scale.value == pytest.approx(1.0 / 1.3, rel=0.05)


@given(st.lists(st.tuples(st.floats(-1.7e308, 1.7e308), st.floats(-1.7e308, 1.7e308)), max_size=30))
def test_factors_are_bounded_and_estimates_finite(samples: list[tuple[float, float]]) -> None:
    extreme = {"adapt.lag_time_constant": 1e-9, "adapt.scale_time_constant": 1e-9}
    steps = {"s1.spike_threshold": 0.5, "s1.timeout": 0.05}
    for parameters in (ADAPTING, replace(ADAPTING, extreme), replace(ADAPTING, steps)):
        fast, slow = [a for a, _ in samples], [b for _, b in samples]
        values, adapted, _ = run(parameters, fast, slow)
        assert np.isfinite(values).all()
        for lag, scale in adapted:
            assert 1.0 / LARGEST_LAG <= lag.value <= LARGEST_LAG
            assert 1.0 / LARGEST_SCALE <= scale.value <= LARGEST_SCALE
