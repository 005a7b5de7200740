# SPDX-License-Identifier: Apache-2.0
"""Why an estimate is what it is, in words, and which parameter would change it."""

from __future__ import annotations

from fuzzy_fusion_ros.core.aggregator import FiringStrengths, sign
from fuzzy_fusion_ros.core.conditioning import is_off
from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.fusion import Parameters, Weights
from fuzzy_fusion_ros.self_tuning import in_use

RULE_WEIGHTS = ("small", "large", "very_small", "very_large")
"""Table 1: the name of the weight that each rule concludes."""


def explanation(parameters: Parameters, fused: Fused, unit: str = "") -> str:
    """Return why an estimate is what it is, and which parameter would change it.

    The numbers reproduce the estimate to the digits that are printed.

    Args:
        parameters: Those given.
        fused: The estimate.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    u = f" {unit}" if unit else ""
    given, parameters = parameters, in_use(parameters, fused.state)
    estimate = fused.estimate
    text = f"The estimate {estimate.value:.6g}{u} is "
    if estimate.accepted:
        text += f"the mean of the prediction, {estimate.prediction.value:.6g}{u}, and of "
        text += f"{estimate.aggregate.value:.6g}{u}, which is "
    if estimate.mode == FUSED:
        by = _observed if observes(parameters) else _blended
        text += by(parameters, fused, u)
        text += _rejected_prediction(parameters, fused, u)
        if given.self_tuning:
            text += ". The parameters are measured; to set them yourself, switch self_tuning off."
        else:
            text += f". {_advice(parameters.aggregator.weight, estimate.aggregate.strengths)}"
    elif estimate.mode == S1_ONLY:
        text += f"S1 alone{_corrected_s1(parameters, fused, u)}: {_s2_silence(fused)}"
    else:
        text += f"S2 alone: {_s1_silence(fused)}"
    return text


def _blended(parameters: Parameters, fused: Fused, u: str) -> str:
    """Return the paper's blend: both sensors, weighed, and the drift."""
    sensors, aggregate = fused.state.sensors, fused.estimate.aggregate
    s1, s2 = sensors.s1.smooth.value - fused.turned, sensors.s2.value - fused.turned
    drift = sign(sensors.s2.rate) * aggregate.drift
    added = (
        f", {'plus' if drift > 0.0 else 'minus'} a drift of {abs(drift):.4g}{u}" if drift else ""
    )
    return (
        f"{aggregate.weight:.4g} of S1{_how(parameters, fused)}, {s1:.6g}{u}, and "
        f"{1.0 - aggregate.weight:.4g} of S2, {s2:.6g}{u} and {_s2_age(fused):.3g} s old{added}: "
        f"they are {abs(s1 - s2):.3g}{u} apart ({_apart(fused)} large), "
        f"S2 moves at {_rate(fused, u)}"
    )


def _observed(parameters: Parameters, fused: Fused, u: str) -> str:
    """Return the observer's estimate: S1 minus its bias, learnt from S2 through its lag."""
    innovation = fused.state.sensors.belief.innovation
    direction = "above" if innovation < 0.0 else "below"
    believed = 100.0 * (1.0 - fused.estimate.aggregate.weight)
    return (
        f"S1{_corrected_s1(parameters, fused, u)}: S2, {_s2_age(fused):.3g} s old, was "
        f"{abs(innovation):.3g}{u} {direction} what the estimate predicted for it "
        f"({_apart(fused)} large), of which {believed:.3g} % is trusted, and S2 moved at "
        f"{_rate(fused, u)}"
    )


def _corrected_s1(parameters: Parameters, fused: Fused, u: str) -> str:
    """Return S1 as it counts, and what is taken off it."""
    if is_off(parameters.s1):
        return ""
    sensors = fused.state.sensors
    text = f"{_how(parameters, fused)}, {sensors.s1.smooth.value - fused.turned:.6g}{u}"
    if observes(parameters):
        scale = sensors.belief.adaptation.scale.value
        bias = sensors.belief.states.bias + (1.0 - scale) * fused.turned
        text += f", times {scale:.4g}" if scale != 1.0 else ""
        text += f", minus its bias, {bias:.6g}{u}"
    return text


def _how(parameters: Parameters, fused: Fused) -> str:
    """Return what conditioning makes of S1."""
    rejected = fused.state.sensors.s1.smooth.rejected
    if rejected > 0.0:
        return f", rejected as a spike for {rejected:.3g} s and extrapolated"
    return "" if is_off(parameters.s1) else ", conditioned"


def _s2_age(fused: Fused) -> float:
    return seconds_between(fused.state.sensors.s2.stamp_ns, fused.stamp_ns)


def _apart(fused: Fused) -> str:
    strengths = fused.estimate.aggregate.strengths
    return f"{100.0 * (strengths.large_small + strengths.large_large):.3g} %"


def _rate(fused: Fused, u: str) -> str:
    strengths = fused.estimate.aggregate.strengths
    per_s = f" ({u.strip()})/s" if "/" in u else f"{u}/s"
    moving = 100.0 * (strengths.small_large + strengths.large_large)
    return f"{fused.state.sensors.s2.rate:.3g}{per_s} ({moving:.3g} % large)"


def _rejected_prediction(parameters: Parameters, fused: Fused, u: str) -> str:
    prediction = fused.estimate.prediction
    if fused.estimate.accepted or not prediction.exists:
        return ""
    return (
        f"; the prediction, {prediction.value:.6g}{u}, is further away than gate.tolerance, "
        f"{parameters.gate.tolerance:.3g}{u}, and is ignored"
    )


def _advice(weights: Weights, strengths: FiringStrengths) -> str:
    """Return what to change either way: the level within whose range the weight moves furthest."""
    levels = {name: getattr(weights, name) for name in RULE_WEIGHTS}
    fired = dict(zip(RULE_WEIGHTS, strengths, strict=True))
    falls = {name: fired[name] * level for name, level in levels.items()}
    rises = {name: fired[name] * (1.0 - level) for name, level in levels.items()}
    down, up = max(falls, key=falls.__getitem__), max(rises, key=rises.__getitem__)
    to_s2, to_s1 = (f"aggregator.weight.{name}, which is {levels[name]:.4g}" for name in (down, up))
    if falls[down] <= 0.0:
        return f"To trust S1 more, raise {to_s1}."
    text = f"To trust S2 more, lower {to_s2}"
    if rises[up] <= 0.0:
        return f"{text}."
    return f"{text}; to trust S1 more, raise {'it' if up == down else to_s1}."


def _s2_silence(fused: Fused) -> str:
    s2 = fused.state.sensors.s2
    heard_ns = s2.stamp_ns if s2.samples else fused.state.started_ns
    return _silence("s2", seconds_between(heard_ns, fused.stamp_ns))


def _s1_silence(fused: Fused) -> str:
    heard_ns = fused.state.sensors.s1.stamp_ns
    if not heard_ns:
        return "S1 has not been received. To use it, check its topic, type and stamps."
    return _silence("s1", seconds_between(heard_ns, fused.stamp_ns))


def _silence(name: str, seconds: float) -> str:
    return (
        f"{name.upper()} has been silent for {seconds:.3g} s, longer than {name}.timeout allows. "
        f"To wait longer for it, raise {name}.timeout."
    )
