# SPDX-License-Identifier: Apache-2.0
"""Parameters changed while samples come in."""

from __future__ import annotations

import pytest
from reference import signals

from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000

PLAIN = replace(Parameters(), {"s1.timeout": 1.0, "s2.timeout": 5.0})
PREDICTING = replace(PLAIN, {"predictor.enabled": True})
RECORDING = signals.regular(200)


def feed(fusion: Fusion, start: int = 0, end: int = 200) -> list[Fused]:
    """Feed samples of the recording, S2 first, and return the estimates."""
    said: list[Fused] = []
    for s1, s2 in zip(RECORDING.s1[start:end], RECORDING.s2[start:end], strict=True):
        said += fusion.on_s2(Sample(*s2)).estimates + fusion.on_s1(Sample(*s1)).estimates
    return said


def change_half_way(before: Parameters, after: Parameters) -> tuple[list[Fused], Fusion]:
    """Feed a recording, change the parameters in its middle; return the second half's estimates."""
    fusion = Fusion(before)
    feed(fusion, end=100)
    fusion.parameters = after
    assert fusion.parameters is after
    return feed(fusion, start=100), fusion


def test_changed_numbers_count_from_the_next_sample_on() -> None:
    everything_to_s1 = {
        f"aggregator.weight.{n}": 1.0 for n in ("very_small", "small", "large", "very_large")
    }
    driftless = {"aggregator.drift.small": 0.0, "aggregator.drift.large": 0.0}
    said, _ = change_half_way(PLAIN, replace(PLAIN, {**everything_to_s1, **driftless}))
    s1 = [value for _, value in RECORDING.s1[100:]]
    assert [fused.estimate.value for fused in said] == pytest.approx(s1, rel=1e-12)


def test_setting_what_is_there_changes_nothing() -> None:
    said, _ = change_half_way(PREDICTING, PREDICTING)
    assert said == feed(Fusion(PREDICTING))[100:]


@pytest.mark.parametrize(
    "change",
    [
        {"predictor.samples": 10},
        {"predictor.rules": 3},
        {"predictor.slope": 2.0},
        {"predictor.lead": 2.0},
    ],
)
def test_other_first_rules_restart_the_predictor(change: dict[str, object]) -> None:
    changed = replace(PREDICTING, change)
    said, _ = change_half_way(PREDICTING, changed)
    exists = [fused.estimate.prediction.exists for fused in said]
    assert not any(exists[: changed.predictor.samples])
    assert any(exists)
    assert {fused.estimate.mode for fused in said} == {FUSED}


@pytest.mark.parametrize("number", ["predictor.learning_rate", "gate.tolerance"])
def test_another_number_of_the_predictor_leaves_its_history(number: str) -> None:
    said, _ = change_half_way(PREDICTING, replace(PREDICTING, {number: 0.07}))
    assert said[0].estimate.prediction.exists


def test_a_predictor_switched_off_predicts_no_more() -> None:
    said, _ = change_half_way(PREDICTING, PLAIN)
    assert not any(fused.estimate.prediction.exists for fused in said)


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_a_changed_timeout_counts_at_once(trigger: str) -> None:
    before = replace(PLAIN, {"trigger": trigger})
    _, fusion = change_half_way(before, replace(before, {"s2.timeout": 0.1}))
    (fused,) = fusion.on_s1(Sample(4 * SECOND, 0.5)).estimates
    assert fused.estimate.mode == S1_ONLY


def test_a_rejected_change_leaves_everything_as_it_was() -> None:
    fusion = Fusion(PLAIN)
    first = feed(fusion, end=100)
    with pytest.raises(ParameterError, match=r"gate\.tolerance"):
        fusion.parameters = replace(fusion.parameters, {"gate.tolerance": -1.0})
    assert first + feed(fusion, start=100) == feed(Fusion(PLAIN))


@pytest.mark.parametrize(
    "change",
    [
        {"s1.lowpass_time_constant": 1.0},
        {"s1.spike_threshold": 0.5},
        {"s1.bias_time_constant": 1.0, "s2.lag_time_constant": 1.0},
    ],
)
def test_conditioning_switched_on_starts_from_the_signal(change: dict[str, object]) -> None:
    """Not from what was kept before it was switched off, or from nothing."""
    fusion = Fusion(PLAIN)
    for k in range(200):
        if k == 100:
            fusion.parameters = replace(PLAIN, change)
        stamp_ns = SECOND + k * 10_000_000
        fusion.on_s2(Sample(stamp_ns, 5.0))
        (fused,) = fusion.on_s1(Sample(stamp_ns, 5.0)).estimates
        assert fused.estimate.value == pytest.approx(5.0)
        assert fused.estimate.aggregate.strengths.small_small == pytest.approx(1.0)


def test_a_bias_switched_off_is_taken_off_no_more() -> None:
    learning = replace(PLAIN, {"s1.bias_time_constant": 1.0, "s1.lowpass_time_constant": 0.01})
    fusion = Fusion(learning)
    strengths = []
    for k in range(400):
        if k == 200:
            fusion.parameters = replace(learning, {"s1.bias_time_constant": 0.0})
        stamp_ns = SECOND + k * 10_000_000
        fusion.on_s2(Sample(stamp_ns, 0.0))
        (fused,) = fusion.on_s1(Sample(stamp_ns, 9.0)).estimates
        strengths.append(fused.estimate.aggregate.strengths)
    assert strengths[199].small_small == pytest.approx(1.0)
    assert strengths[399].large_small == pytest.approx(1.0)
