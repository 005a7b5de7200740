# SPDX-License-Identifier: Apache-2.0
"""The fuzzy predictor: what it predicts, and when it rather says nothing."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from searching import examples

from fuzzy_fusion_ros.core.gate import Prediction
from fuzzy_fusion_ros.core.predictor import (
    LONGEST_STEP,
    Predictor,
    learn,
    prediction_at,
    untrained,
)
from fuzzy_fusion_ros.parameters.fusion import PredictorParameters

SECOND = 1_000_000_000
STEP = 10_000_000
ENABLED = PredictorParameters(enabled=True, slope=6.0, lead=1.0)


def fed(
    values: Sequence[float], parameters: PredictorParameters = ENABLED, step_ns: int = STEP
) -> tuple[Predictor, list[Prediction]]:
    """Feed estimates; return the state and what had been predicted for each."""
    state = untrained(parameters.samples, parameters.rules)
    predictions = []
    for k, value in enumerate(values):
        stamp_ns = SECOND + k * step_ns
        predictions.append(prediction_at(parameters, state, stamp_ns))
        state = learn(parameters, state, stamp_ns, value)
    return state, predictions


def next_stamp(values: Sequence[float]) -> int:
    """Return the stamp after the last of ``fed``."""
    return SECOND + len(values) * STEP


def wave(samples: int, amplitude: float = 1.0) -> list[float]:
    """Return a slow oscillation."""
    return [amplitude * math.sin(0.05 * k) for k in range(samples)]


def test_nothing_is_predicted_before_the_history_is_full() -> None:
    _, predictions = fed(wave(60))
    assert not any(prediction.exists for prediction in predictions[: ENABLED.samples])
    assert any(prediction.exists for prediction in predictions)


def test_a_smooth_signal_is_predicted_better_than_by_the_last_value() -> None:
    values = wave(1000)
    _, predictions = fed(values)
    said = [prediction.value for prediction in predictions]
    ours = math.fsum(abs(said[k] - values[k]) for k in range(500, 1000))
    last_value = math.fsum(abs(values[k - 1] - values[k]) for k in range(500, 1000))
    assert all(prediction.exists for prediction in predictions[500:])
    assert ours < 0.5 * last_value


def test_training_goes_on_from_what_was_learnt() -> None:
    values = wave(100)
    state, _ = fed(values)
    other, _ = fed(wave(100, amplitude=3.0))
    both = (state, state._replace(rules=other.rules))
    one, two = (learn(ENABLED, each, next_stamp(values), 0.0).increment for each in both)
    assert one != two


@pytest.mark.parametrize("level", [0.0, 1.0, -3e5, 1e99])
def test_a_constant_is_predicted_to_go_on(level: float) -> None:
    _, predictions = fed([level] * 100)
    assert predictions[-1].exists
    assert predictions[-1].value == pytest.approx(level, abs=1e-12)


def test_a_signal_is_predicted_the_same_at_any_level() -> None:
    """The inputs are differences to the newest estimate."""
    _, low = fed(wave(300))
    _, high = fed([64.0 + value for value in wave(300)])
    assert [p.exists for p in low] == [p.exists for p in high]
    shifted = [p.value - 64.0 if p.exists else 0.0 for p in high]
    assert shifted == pytest.approx([p.value for p in low], abs=1e-9)


def test_after_a_leap_out_of_all_rules_there_is_no_prediction() -> None:
    untaught = PredictorParameters(enabled=True, max_iterations=0)
    state, _ = fed(wave(300, amplitude=0.01), untaught)
    assert prediction_at(untaught, state, next_stamp(range(300))).exists
    state = learn(untaught, state, next_stamp(range(300)), 1e6)
    assert not prediction_at(untaught, state, next_stamp(range(301))).exists


@pytest.mark.parametrize("leap", [1.0, 1e6, 1e300])
def test_after_a_leap_and_back_it_predicts_again(leap: float) -> None:
    values = wave(2000, amplitude=0.2)
    values[500] = leap
    _, predictions = fed(values)
    assert all(prediction.exists for prediction in predictions[-100:])
    errors = [abs(p.value - x) for p, x in zip(predictions[-100:], values[-100:], strict=True)]
    assert max(errors) < 0.02


@pytest.mark.parametrize(
    ("steps", "exists"), [(1, True), (LONGEST_STEP, True), (LONGEST_STEP + 1, False)]
)
def test_a_gap_has_no_prediction(steps: int, exists: bool) -> None:
    state, _ = fed(wave(300))
    stamp_ns = next_stamp(range(299)) + steps * STEP
    assert prediction_at(ENABLED, state, stamp_ns).exists is exists


def test_a_gap_restarts_the_history() -> None:
    state, _ = fed(wave(300))
    stamp_ns = next_stamp(range(300)) + 10 * STEP
    seen = []
    for k in range(100):
        seen.append(prediction_at(ENABLED, state, stamp_ns + k * STEP).exists)
        state = learn(ENABLED, state, stamp_ns + k * STEP, math.sin(0.05 * k))
    assert not any(seen[: ENABLED.samples])
    assert any(seen)


def test_a_prediction_goes_as_far_as_the_time_that_passed() -> None:
    state, _ = fed([0.01 * k for k in range(300)])
    newest = 0.01 * 299
    one = prediction_at(ENABLED, state, next_stamp(range(300)))
    half = prediction_at(ENABLED, state, next_stamp(range(300)) - STEP // 2)
    two = prediction_at(ENABLED, state, next_stamp(range(301)))
    assert one.exists
    assert half.value - newest == pytest.approx((one.value - newest) / 2.0)
    assert two.value - newest == pytest.approx((one.value - newest) * 2.0)


def test_switched_off_it_neither_learns_nor_predicts() -> None:
    off = PredictorParameters(enabled=False)
    state, _ = fed(wave(300))
    assert learn(off, state, next_stamp(range(300)), 0.5) is state
    assert not prediction_at(off, state, next_stamp(range(300))).exists


def test_two_predictors_are_the_same_bit_for_bit() -> None:
    values = np.cumsum(np.random.default_rng(41).normal(0.0, 0.1, 400)).tolist()
    (one, first), (other, second) = fed(values), fed(values)
    assert first == second
    assert one == other


FINITE = st.floats(allow_nan=False, allow_infinity=False)


@examples(60)
@given(
    st.lists(FINITE, min_size=30, max_size=60),
    st.sampled_from([0.0, 0.1, 1.0]),
    st.sampled_from([(3, 2), (5, 4), (20, 5)]),
)
@example([1.7e308, -1.7e308] * 25, 1.0, (3, 2))
@example([1e100, -1e100] * 25, 1.0, (5, 4))
@example([5e-324, 0.0] * 25, 1.0, (5, 4))
@example([0.0] * 20 + [1e308] + [0.0] * 20, 1.0, (3, 2))
@example([0.0, 1.0, 1e200, -1e-200] * 12, 1.0, (5, 4))
def test_whatever_is_fed_a_prediction_is_finite(
    values: list[float], learning_rate: float, shape: tuple[int, int]
) -> None:
    """No overflow on the way either: numpy would warn, and warnings are errors here."""
    parameters = PredictorParameters(
        enabled=True,
        samples=shape[0],
        rules=shape[1],
        learning_rate=learning_rate,
        max_iterations=20,
        error_threshold=0.0,
    )
    state, predictions = fed(values, parameters)
    assert all(math.isfinite(prediction.value) for prediction in predictions)
    for family in state.rules:
        assert np.isfinite(family).all()
    assert min(state.rules.widths) > 0.0
