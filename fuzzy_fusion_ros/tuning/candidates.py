# SPDX-License-Identifier: Apache-2.0
"""The structures that ``tune`` chooses from: what a fit of each moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.self_tuning import homes
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.fit import Evaluations, FitSpec
from fuzzy_fusion_ros.tuning.search import MEMBERS
from fuzzy_fusion_ros.tuning.space import (
    LAGS,
    WEIGHTS,
    Axis,
    Follow,
    Space,
    aggregator_axes,
    bias_axes,
    has_lag_to_fit,
    noise_axis,
    nothing_follows,
    rule_axes,
    slope_axes,
    space_of,
    usual_bias_time,
    very_large,
)

EVALUATIONS = MappingProxyType(
    {
        True: Evaluations(60, 1, 1, finalists=2),
        False: Evaluations(250, 600, 300),
    }
)
"""Evaluations of the evolution in a fit of each candidate, up to ``LONG`` samples of S1, with a
truth and without: with a truth least squares do the rest."""

LONG = 40_000
"""With more samples there are fewer evaluations in proportion, so that a fit takes no longer."""

FEWEST = 0.25
"""But at least this share of them, however long the recording."""

LOST_AFTER = 3.0
"""S2 counts as lost after this many of its intervals without a sample, and its delivery time."""

PAUSES = 1.5
"""Nor does it before this many of the longest pauses that are usual,"""

HICCUP = (0.5, 50.0)
"""nor before this many seconds, which a busy computer may delay a sample, or at a time scale where
that is long, this many intervals."""


class Candidate(NamedTuple):
    """A structure of the fusion that may be chosen.

    Attributes:
        name: Its name.
        text: What it does.
        spec: What a fit of it moves.
    """

    name: str
    text: str
    spec: FitSpec


def candidates_for(sensors: Characteristics, with_truth: bool = True) -> list[Candidate]:
    """Return the candidates for such sensors: a sensor alone, the paper's rules, the observers.

    Args:
        sensors: What the sensors are like.
        with_truth: Whether the target is a truth; without, the observer is fitted to what S2 says,
            and keeps S2's lag as measured unless that is sure, or a lower bound.
    """
    hiccup = min(HICCUP[0], HICCUP[1] * sensors.s2_interval)
    silence = max(LOST_AFTER * sensors.s2_interval, PAUSES * sensors.s2_pause, hiccup)
    lost = silence + sensors.s2_delivery
    patient = max(lost, 2.0 * sensors.s2_gap + sensors.s2_delivery)
    return [
        Candidate("s2", "raw S2", _alone(0.0, patient)),
        Candidate("s1", "raw S1", _alone(1.0, lost)),
        Candidate(
            "aggregator", "the paper's rules on raw S1", _aggregator(sensors, lost, with_truth)
        ),
        Candidate(
            "bias",
            "S1 minus its bias, learnt from S2",
            _observer("bias", sensors, lost, with_truth),
        ),
        Candidate("slope", "the bias with a slope", _observer("slope", sensors, lost, with_truth)),
        Candidate(
            "full",
            "the same, S2 trusted by the rules",
            _observer("full", sensors, lost, with_truth),
        ),
    ]


def _alone(weight: float, timeout: float) -> FitSpec:
    space = _space((), {**_weights(*[weight] * 4), **_OFF, "s2.timeout": timeout})
    return FitSpec(space, ({},), Evaluations(1, 1, 1))


def _aggregator(sensors: Characteristics, lost: float, with_truth: bool) -> FitSpec:
    space = _space(aggregator_axes(sensors), {**_OFF, "s2.timeout": lost})
    starts = (_weights(0.9, 0.9, 0.98, 0.98), _weights(0.02, 0.05, 0.3, 0.7))
    return FitSpec(space, starts, _evaluations(sensors, with_truth))


def _observer(name: str, sensors: Characteristics, lost: float, with_truth: bool) -> FitSpec:
    """Return what a fit of the observer moves: without rules, S2 counts as its noise says."""
    has_slope, has_rules = name != "bias", name == "full"
    usual = usual_bias_time(sensors, has_slope)
    axes = bias_axes(sensors, usual)
    axes += slope_axes(sensors) if has_slope else []
    axes += rule_axes(sensors) if has_rules else []
    fixed = {
        **_OFF,
        **_weights(0.0, 0.0, 0.0, 0.0),
        **homes.safety_net(0.0),
        "aggregator.rate.small": 0.0,
        "aggregator.rate.large": 0.5 * sensors.rate,
        "aggregator.rate_time_constant": homes.rate_time_constant(sensors.s2_interval),
        "s2.noise": sensors.s2_noise,
        "s2.timeout": lost,
    }
    bias, drift = "s1.bias_time_constant", "s1.drift_time_constant"
    starts: Sequence[Mapping[str, float]] = (
        {},
        {
            "s1.lowpass_time_constant": 30.0 * sensors.s1_interval,
            bias: 10.0 * usual,
            "aggregator.weight.large": 0.95,
            "aggregator.rate.large": 0.05 * sensors.rate,
        },
        {bias: 0.1 * usual, drift: 300.0 * sensors.span, "aggregator.weight.large": 1.0 / 3.0},
    )
    if not with_truth:
        if not has_lag_to_fit(sensors):
            fixed |= {each.name: each.usual for each in axes if each.name in LAGS}
            axes = [each for each in axes if each.name not in LAGS]
        axes.append(noise_axis(sensors))
    space = _space(axes, fixed, very_large if has_rules else nothing_follows)
    return FitSpec(space, starts, _evaluations(sensors, with_truth))


def _space(
    axes: Sequence[Axis], fixed: Mapping[str, float], follow: Follow = nothing_follows
) -> Space:
    return space_of(Parameters, axes, fixed, follow)


def _evaluations(sensors: Characteristics, with_truth: bool) -> Evaluations:
    samples = sensors.span / sensors.s1_interval
    share = max(FEWEST, min(1.0, LONG / samples))
    given = EVALUATIONS[with_truth]
    start, finalist, part = (max(round(share * each), 1) for each in given[:3])
    return given._replace(start=max(start, 2 * MEMBERS), finalist=finalist, part=part)


def _weights(*levels: float) -> dict[str, float]:
    return {f"aggregator.weight.{each}": level for each, level in zip(WEIGHTS, levels, strict=True)}


_OFF = {
    "aggregator.drift.small": 0.0,
    "aggregator.drift.large": 0.0,
    "s1.spike_threshold": 0.0,
    "s1.lowpass_time_constant": 0.0,
    "s1.bias_time_constant": 0.0,
    "s1.bias_prior": 0.0,
    "s1.drift_time_constant": 0.0,
    "s1.drift_prior": 0.0,
    "s2.noise": 0.0,
    "s2.lag_time_constant": 0.0,
    "s2.delay": 0.0,
}
"""No conditioning of S1, no observer, no drift."""
