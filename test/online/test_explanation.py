# SPDX-License-Identifier: Apache-2.0
"""Why an estimate is what it is, in words."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY, S2_ONLY
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.explanation import explanation
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

NUMBER = r"(-?\d[\d.]*(?:e[+-]?\d+)?)"
HOW = r"(?:, conditioned|, rejected as a spike for \S+ s and extrapolated)?"
BLEND = re.compile(
    rf"{NUMBER} of S1{HOW}, {NUMBER} rad, and {NUMBER} of S2, {NUMBER} rad and "
    rf"{NUMBER} s old(?:, (plus|minus) a drift of {NUMBER} rad)?:"
)
OBSERVED = re.compile(rf"is S1{HOW}, {NUMBER} rad, minus its bias, {NUMBER} rad:")
MEAN = re.compile(rf"the mean of the prediction, {NUMBER} rad, and of {NUMBER} rad, which is ")
DIGITS = 6e-4
"""Relative error that printing leaves: four digits of weights and drift."""


def said(parameters: Parameters, fused: Fused) -> tuple[float, float]:
    """Return the estimate that a sentence names, and what its other numbers amount to."""
    text = explanation(parameters, fused, "rad")
    named = re.match(rf"The estimate {NUMBER} rad is ", text)
    assert named is not None, text
    mean = MEAN.search(text)
    if parameters.s1.bias_time_constant > 0.0:
        observed = OBSERVED.search(text)
        assert observed is not None, text
        value = float(observed[1]) - float(observed[2])
    else:
        blend = BLEND.search(text)
        assert blend is not None, text
        weight, s1, rest, s2, _, direction, drift = blend.groups()
        value = float(weight) * float(s1) + float(rest) * float(s2)
        if direction:
            value += float(drift) if direction == "plus" else -float(drift)
    if mean is not None:
        assert value == pytest.approx(float(mean[2]), abs=DIGITS * size(fused))
        value = 0.5 * (float(mean[1]) + float(mean[2]))
    return float(named[1]), value


def size(fused: Fused) -> float:
    """Return how large the numbers are that an estimate is made of."""
    sensors, drift = fused.state.sensors, fused.estimate.aggregate.drift
    bias = sensors.belief.states.bias
    return abs(sensors.s1.smooth.value) + abs(sensors.s2.value) + abs(bias) + drift


def estimates(parameters: Parameters, samples: list[tuple[str, float, float]]) -> list[Fused]:
    """Return the estimates of samples: sensor, seconds, value."""
    fusion = Fusion(parameters)
    receive = {"s1": fusion.on_s1, "s2": fusion.on_s2}
    return [
        fused
        for sensor, time_s, value in samples
        for fused in receive[sensor](Sample(round((1.0 + time_s) * 1e9), value)).estimates
    ]


values = st.floats(-1e3, 1e3)
shares = st.floats(0.0, 1.0)


@given(
    samples=st.lists(st.tuples(values, values), min_size=2, max_size=30),
    weights=st.tuples(shares, shares, shares, shares),
    drift=st.floats(0.0, 10.0),
    large=st.floats(0.1, 1e3),
    predicts=st.booleans(),
    lowpass=st.sampled_from([0.0, 0.05]),
    bias=st.sampled_from([0.0, 2.0]),
)
@settings(deadline=None)
def test_the_numbers_of_the_sentence_make_the_estimate(
    samples: list[tuple[float, float]],
    weights: tuple[float, float, float, float],
    drift: float,
    large: float,
    predicts: bool,
    lowpass: float,
    bias: float,
) -> None:
    names = ("very_small", "small", "large", "very_large")
    changes: dict[str, object] = {
        **{f"aggregator.weight.{name}": w for name, w in zip(names, weights, strict=True)},
        "aggregator.drift.large": drift,
        "aggregator.difference.small": 0.0,
        "aggregator.difference.large": large,
        "predictor.enabled": predicts,
        "predictor.samples": 3,
        "gate.tolerance": 1e3,
        "s1.lowpass_time_constant": lowpass,
        "s1.bias_time_constant": bias,
        "s2.lag_time_constant": 0.2,
        "s1.spike_threshold": 500.0 if lowpass else 0.0,
    }
    parameters = replace(Parameters(), changes)
    stream = [
        (sensor, 0.01 * k, value)
        for k, pair in enumerate(samples)
        for sensor, value in zip(("s2", "s1"), pair, strict=True)
    ]
    for fused in estimates(parameters, stream):
        assert fused.estimate.mode == FUSED
        named, amounts = said(parameters, fused)
        assert named == pytest.approx(fused.estimate.value, rel=1e-5)
        assert amounts == pytest.approx(fused.estimate.value, abs=DIGITS * size(fused) + 1e-9)


def test_it_says_what_happened_and_what_to_change() -> None:
    changes: dict[str, object] = {
        "aggregator.rate_time_constant": 0.0,
        "aggregator.difference.small": 0.0,
        "aggregator.rate.small": 0.0,
        "aggregator.rate.large": 1.0,
    }
    parameters = replace(Parameters(), changes)
    stream = [("s2", 0.0, 0.0), ("s2", 0.1, 0.09), ("s1", 0.31, 0.57)]
    (fused,) = estimates(parameters, stream)
    assert explanation(parameters, fused, "rad") == (
        "The estimate 0.268354 rad is 0.3243 of S1, 0.57 rad, and 0.6757 of S2, 0.09 rad and "
        "0.21 s old, plus a drift of 0.02268 rad: they are 0.48 rad apart (80 % large), S2 moves "
        "at 0.9 rad/s (90 % large). To trust S2 more, lower aggregator.weight.very_large, which "
        "is 0.42; to trust S1 more, raise it."
    )
    without_unit = explanation(parameters, fused)
    assert "0.57, and 0.6757 of S2, 0.09 and 0.21 s old" in without_unit
    assert "S2 moves at 0.9/s" in without_unit
    assert "S2 moves at 0.9 (m/s)/s" in explanation(parameters, fused, "m/s")


@pytest.mark.parametrize(
    ("level", "advice"),
    [
        (0.0, "To trust S1 more, raise aggregator.weight.very_small, which is 0."),
        (1.0, "To trust S2 more, lower aggregator.weight.very_small, which is 1."),
        (0.5, "To trust S2 more, lower aggregator.weight.very_small, which is 0.5; to trust"),
    ],
)
def test_advice_stays_within_the_range(level: float, advice: str) -> None:
    parameters = replace(Parameters(), {"aggregator.weight.very_small": level})
    (fused,) = estimates(parameters, [("s2", 0.0, 0.0), ("s1", 0.0, 5.0)])
    assert advice in explanation(parameters, fused)


def test_advice_names_the_levels_that_move_the_weight_furthest() -> None:
    """Not that of the strongest rule, where it is 0 and no other sample of S2 could count more."""
    changes: dict[str, object] = {
        "aggregator.rate_time_constant": 0.0,
        "aggregator.rate.small": 0.0,
        "aggregator.rate.large": 10.0,
        "aggregator.weight.small": 0.0,
    }
    parameters = replace(Parameters(), changes)
    (fused,) = estimates(parameters, [("s2", 0.0, 0.0), ("s2", 0.1, 0.2), ("s1", 0.1, 0.2)])
    assert explanation(parameters, fused).endswith(
        "(20 % large). To trust S2 more, lower aggregator.weight.large, which is 0.12; to trust S1 "
        "more, raise aggregator.weight.small, which is 0."
    )


def test_a_prediction_that_does_not_count_is_named() -> None:
    parameters = replace(Parameters(), {"predictor.enabled": True, "gate.tolerance": 1e-6})
    steps = []
    for k in range(80):
        steps += [("s2", 0.01 * k, 0.02 * k), ("s1", 0.01 * k, 0.02 * k + 0.1 * (-1) ** k)]
    rejected = [
        each
        for each in estimates(parameters, steps)
        if each.estimate.prediction.exists and not each.estimate.accepted
    ]
    assert rejected
    assert "is further away than gate.tolerance, 1e-06 rad, and is ignored" in explanation(
        parameters, rejected[-1], "rad"
    )


def test_a_sensor_alone_says_for_how_long_the_other_has_been_silent() -> None:
    parameters = replace(Parameters(), {"s1.timeout": 1.0, "s2.timeout": 2.0})
    s1 = [("s1", 0.5 * k, 0.25) for k in range(10)]
    alone = estimates(parameters, [("s2", 0.0, 0.5), *s1])[-1]
    assert alone.estimate.mode == S1_ONLY
    assert explanation(parameters, alone, "m") == (
        "The estimate 0.25 m is S1 alone: S2 has been silent for 4.5 s, longer than s2.timeout "
        "allows. To wait longer for it, raise s2.timeout."
    )
    s2 = [("s2", 0.5 * k, 0.75) for k in range(1, 10)]
    alone = estimates(parameters, [("s1", 0.0, 0.5), *s2])[-1]
    assert alone.estimate.mode == S2_ONLY
    assert explanation(parameters, alone) == (
        "The estimate 0.75 is S2 alone: S1 has been silent for 4.5 s, longer than s1.timeout "
        "allows. To wait longer for it, raise s1.timeout."
    )
    never = estimates(parameters, s2)[-1]
    assert "S2 alone: S1 has not been received." in explanation(parameters, never)
    conditioned = replace(parameters, {"s1.lowpass_time_constant": 0.1})
    alone = estimates(conditioned, s1)[-1]
    assert "S1 alone, conditioned, 0.25: S2 has been silent" in explanation(conditioned, alone)


def test_the_observer_says_what_s1_is_off_by_and_what_s2_surprised_it_with() -> None:
    parameters = replace(Parameters(), {"s1.bias_time_constant": 2.0, "s2.noise": 0.1})
    stream = [
        (name, 0.1 * k, value) for k in range(50) for name, value in (("s1", 1.5), ("s2", 1.0))
    ]
    *_, fused = estimates(parameters, [*stream, ("s2", 5.0, 1.25), ("s1", 5.21, 1.5)])
    belief = fused.state.sensors.belief
    text = explanation(parameters, fused, "m")
    assert belief.states.bias == pytest.approx(0.5, abs=0.2)
    assert f"conditioned, 1.5 m, minus its bias, {belief.states.bias:.6g} m" in text
    assert "S2, 0.21 s old, was 0.25 m above what the estimate predicted for it" in text
    assert f"of which {100.0 - 100.0 * belief.weight:.3g} % is trusted, and S2 moved at" in text
    alone = estimates(parameters, [*stream, ("s1", 30.0, 1.5), ("s1", 30.1, 1.5)])[-1]
    assert alone.estimate.mode == S1_ONLY
    assert "is S1 alone, conditioned, 1.5 m, minus its bias, " in explanation(
        parameters, alone, "m"
    )


def test_a_spike_is_named() -> None:
    parameters = replace(Parameters(), {"s1.spike_threshold": 0.5})
    stream = [("s2", 0.0, 1.0), ("s1", 0.0, 1.0), ("s1", 0.1, 1.0), ("s1", 0.2, 9.0)]
    spike = estimates(parameters, stream)[-1]
    assert "S1, rejected as a spike for 0.1 s and extrapolated, 1 m" in explanation(
        parameters, spike, "m"
    )


@pytest.mark.parametrize("bias", [0.0, 2.0])
def test_the_numbers_are_turned_as_the_estimate_is(bias: float) -> None:
    """A heading that has wrapped more than once."""
    period = 2.0 * math.pi
    parameters = replace(
        Parameters(), {"signal.period": period, "s1.bias_time_constant": bias, "s2.noise": 0.1}
    )
    samples: list[tuple[str, float, float]] = []
    for k in range(400):
        angle = 0.05 * k
        samples += [("s2", 0.01 * k, angle % period)] if k % 10 == 0 else []
        samples.append(("s1", 0.01 * k, (angle + 0.2) % period))
    fused = estimates(parameters, samples)[-1]
    assert abs(fused.turned) > 2.0 * period
    named, made = said(parameters, fused)
    assert made == pytest.approx(named, abs=DIGITS * size(fused))
    assert not fused.estimate.prediction.exists
    assert fused.estimate.prediction.value == 0.0


def test_measured_parameters_are_not_advised_to_be_changed() -> None:
    parameters = replace(Parameters(), {"self_tuning": True})
    fused = estimates(parameters, [("s2", 0.0, 1.0), ("s1", 0.01, 1.1), ("s1", 0.02, 1.1)])[-1]
    text = explanation(parameters, fused, "rad")
    assert text.endswith(
        "The parameters are measured; to set them yourself, switch self_tuning off."
    )
