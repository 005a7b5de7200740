# SPDX-License-Identifier: Apache-2.0
"""The estimator: the order of its steps, its modes, and gaps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference import aggregator as reference
from reference import signals

from fuzzy_fusion_ros.core import estimator
from fuzzy_fusion_ros.core.estimator import (
    FUSED,
    S1_ONLY,
    S2_ONLY,
    WAITING,
    Estimate,
    State,
    initial_state,
    mode_at,
    observe_s2,
    update,
    without_s1,
)
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers, replace

SECOND = 1_000_000_000
STEP = 10_000_000

PINNED = replace(
    Parameters(),
    {
        "aggregator.difference.small": 0.0,
        "aggregator.difference.large": 0.3,
        "aggregator.rate.small": 0.0,
        "aggregator.rate.large": 1.0,
        "aggregator.rate_time_constant": 0.03,
        "aggregator.weight.very_small": 0.0,
        "aggregator.weight.small": 0.05,
        "aggregator.weight.large": 0.3,
        "aggregator.weight.very_large": 0.7,
        "aggregator.drift.small": 0.0,
        "aggregator.drift.large": 0.1,
        "predictor.enabled": False,
        "s1.timeout": 1.0,
        "s2.timeout": 5.0,
    },
)
PREDICTING = replace(PINNED, {"predictor.enabled": True, "gate.tolerance": 1e9})


def estimates(parameters: Parameters, recording: signals.Recording) -> list[Estimate]:
    """Feed a recording, sample by sample, and return what is said at each of S1."""
    state = initial_state(parameters)
    said = []
    seen = 0
    for (stamp_ns, value), known in zip(recording.s1, recording.s2_known, strict=True):
        for s2_ns, s2 in recording.s2[seen:known]:
            state = observe_s2(parameters, state, s2_ns, s2)
        seen = known
        estimate, state = update(parameters, state, stamp_ns, value)
        said.append(estimate)
    return said


def after_both(parameters: Parameters, stamp_ns: int = SECOND) -> State:
    """Return the state after one sample of each sensor."""
    state = observe_s2(parameters, initial_state(parameters), stamp_ns, 0.5)
    return update(parameters, state, stamp_ns, 0.5)[1]


@pytest.mark.parametrize("recording", [signals.regular(300), signals.irregular(300)])
def test_without_predictor_it_is_the_aggregator_of_the_reference(
    recording: signals.Recording,
) -> None:
    exact = reference.aggregated(reference.PINNED, 0.03, recording.s1, recording.s2)
    for said, answer in zip(estimates(PINNED, recording), exact, strict=True):
        assert said.mode == FUSED
        assert said.value == said.aggregate.value
        assert said.value == pytest.approx(float(answer.value), rel=1e-9, abs=1e-12)
        assert said.aggregate.weight == pytest.approx(float(answer.weight), rel=1e-9, abs=1e-12)
        assert said.aggregate.drift == pytest.approx(float(answer.drift), rel=1e-9, abs=1e-12)
        assert said.aggregate.strengths == pytest.approx([float(s) for s in answer.strengths])
        assert not said.prediction.exists
        assert not said.accepted


def test_the_steps_are_those_of_the_paper_in_its_order(monkeypatch: pytest.MonkeyPatch) -> None:
    state = after_both(PREDICTING)
    called: list[tuple[str, tuple[Any, ...], Any]] = []

    def watch(name: str) -> None:
        function = getattr(estimator, name)

        def watched(*arguments: Any) -> Any:
            result = function(*arguments)
            called.append((name, arguments, result))
            return result

        monkeypatch.setattr(estimator, name, watched)

    for name in ("condition", "aggregate", "prediction_at", "accepts", "combine", "learn"):
        watch(name)
    said, after = update(PREDICTING, state, SECOND + STEP, 0.6)

    by_name = {name: (arguments, result) for name, arguments, result in called}
    assert list(by_name) == [
        "condition",
        "aggregate",
        "prediction_at",
        "accepts",
        "combine",
        "learn",
    ]
    conditioned = by_name["condition"][1]
    assert by_name["aggregate"][0][1] == conditioned.smooth.value
    assert by_name["prediction_at"][0][-2] is state.predictor  # as it was before this step
    assert by_name["accepts"][0][:2] == (said.prediction, said.aggregate.value)
    assert by_name["learn"][0][-1] == said.value  # the final estimate, after the gate
    assert after.predictor is by_name["learn"][1]


@pytest.mark.parametrize(
    ("since_s2_ns", "mode"),
    [(0, FUSED), (5 * SECOND, FUSED), (5 * SECOND + 1, S1_ONLY)],
)
def test_s2_is_held_until_its_timeout(since_s2_ns: int, mode: int) -> None:
    s2 = observe_s2(PINNED, initial_state(PINNED), SECOND, 0.5).sensors.s2
    assert mode_at(5.0, s2, 0, SECOND + since_s2_ns) == mode


def test_an_s2_that_is_overdue_when_s1_begins_is_lost_not_awaited() -> None:
    state = observe_s2(PINNED, initial_state(PINNED), SECOND, 0.5)
    said, _ = update(PINNED, state, 6 * SECOND + 1, 0.1)
    assert said.mode == S1_ONLY


@pytest.mark.parametrize(
    ("since_start_ns", "mode"),
    [(0, WAITING), (5 * SECOND, WAITING), (5 * SECOND + 1, S1_ONLY)],
)
def test_s2_is_awaited_from_the_first_s1_on(since_start_ns: int, mode: int) -> None:
    state = initial_state(PINNED)
    first, state = update(PINNED, state, SECOND, 0.1)
    assert first.mode == WAITING
    if since_start_ns:
        said, _ = update(PINNED, state, SECOND + since_start_ns, 0.2)
        assert said.mode == mode


def test_s1_alone_is_passed_on_as_it_is() -> None:
    _, state = update(PINNED, initial_state(PINNED), SECOND, 0.1)
    said, _ = update(PINNED, state, 7 * SECOND, 0.25)
    assert (said.mode, said.value, said.aggregate.weight) == (S1_ONLY, 0.25, 1.0)
    assert said.aggregate.drift == 0.0


def test_s2_comes_back_by_itself_and_without_a_spike() -> None:
    state = after_both(PINNED)
    said, state = update(PINNED, state, 7 * SECOND, 0.25)
    assert said.mode == S1_ONLY
    state = observe_s2(PINNED, state, 7 * SECOND + STEP, 90.0)
    assert state.sensors.s2.rate == 0.0
    said, _ = update(PINNED, state, 7 * SECOND + 2 * STEP, 90.0)
    assert (said.mode, said.value) == (FUSED, 90.0)


def test_s2_alone_is_its_held_value() -> None:
    state = after_both(PINNED)
    state = observe_s2(PINNED, state, 3 * SECOND, -0.75)
    said = without_s1(Parameters(), state, state.sensors.s2.stamp_ns)
    assert (said.mode, said.value) == (S2_ONLY, -0.75)
    assert said.aggregate == (-0.75, 0.0, 0.0, (0.0, 0.0, 0.0, 0.0))
    assert not said.prediction.exists


def test_nothing_is_learnt_while_waiting() -> None:
    """A WAITING step gives no estimate, so there is none to learn from."""
    state = initial_state(PREDICTING)
    for k in range(60):
        said, after = update(PREDICTING, state, SECOND + k * STEP, 0.1)
        assert said.mode == WAITING
        assert after.predictor is state.predictor
        state = after


def test_while_s2_is_lost_the_predictor_learns_from_s1_alone() -> None:
    state = after_both(PREDICTING)
    exists = []
    for k in range(60):
        said, state = update(PREDICTING, state, 7 * SECOND + k * STEP, 0.01 * k)
        assert said.mode == S1_ONLY
        exists.append(said.prediction.exists)
    assert any(exists)


def test_an_accepted_prediction_counts_half() -> None:
    said = [e for e in estimates(PREDICTING, signals.regular(200)) if e.prediction.exists]
    assert len(said) > 50
    for each in said:
        assert each.accepted
        mean = (each.prediction.value + each.aggregate.value) / 2.0
        assert each.value == pytest.approx(mean, rel=1e-15)


def test_a_rejected_prediction_counts_nothing() -> None:
    never = replace(PREDICTING, {"gate.tolerance": 0.0})
    said = [e for e in estimates(never, signals.regular(200)) if e.prediction.exists]
    assert len(said) > 50
    for each in said:
        assert each.value == each.aggregate.value or each.accepted


def test_after_a_gap_there_is_no_prediction_until_the_history_is_full_again() -> None:
    recording = signals.irregular(400, gap_ns=20 * SECOND)
    exists = [e.prediction.exists for e in estimates(PREDICTING, recording)]
    fill = PREDICTING.predictor.samples
    assert not any(exists[:fill])
    assert any(exists[fill:200])
    assert not any(exists[200 : 200 + fill])
    assert any(exists[200 + fill :])


@pytest.mark.parametrize("parameters", [PINNED, PREDICTING])
def test_the_numbers_of_the_parameters_serve_as_well(parameters: Parameters) -> None:
    recording = signals.irregular(150)
    assert estimates(numbers(parameters), recording) == estimates(parameters, recording)


def test_a_state_that_goes_in_is_left_as_it_was() -> None:
    """So a state can be kept, compared and gone back to."""

    def snapshot(x: Any) -> Any:
        if isinstance(x, tuple):
            return tuple(snapshot(part) for part in x)
        return x.tobytes() if isinstance(x, np.ndarray) else x

    everything = replace(
        PREDICTING, {"s1.lowpass_time_constant": 0.05, "s1.bias_time_constant": 1.0}
    )
    recording = signals.regular(80)
    state = initial_state(everything)
    for (stamp_ns, s1), (_, s2) in zip(recording.s1, recording.s2, strict=True):
        before = snapshot(state)
        with_s2 = observe_s2(everything, state, stamp_ns, s2)
        between = snapshot(with_s2)
        first, after = update(everything, with_s2, stamp_ns, s1)
        again, _ = update(everything, with_s2, stamp_ns, s1)
        assert snapshot(state) == before
        assert snapshot(with_s2) == between
        assert first == again
        state = after
