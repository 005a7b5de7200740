"""The structures that ``tune`` chooses from, in order of preference: what a fit of each moves.

Either sensor alone comes first. The rules on an unconditioned S1 come last although they are
simpler than the two candidates before them, because those also follow a drift of S1 that the
recording happens not to show.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.fit import Evaluations, FitSpec
from fuzzy_fusion_ros.tuning.space import (
    NEVER,
    WEIGHTS,
    Axis,
    Space,
    aggregator_axes,
    filter_axes,
    learning_axes,
    space_of,
)

EVALUATIONS = MappingProxyType(
    {
        "aggregator": Evaluations(160, 500, 300),
        "conditioned": Evaluations(160, 400, 300),
        "full": Evaluations(360, 1200, 300),
    }
)
"""Evaluations that a fit of each candidate may take, up to ``LONG`` samples of S1."""

LONG = 40_000
"""With more samples there are fewer evaluations in proportion, so that a fit takes no longer."""

FEWEST = 0.25
"""But at least this share of them, however long the recording."""

LOST_AFTER = 3.0
"""S2 counts as lost after this many of its intervals without a sample, and its delivery time."""


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


def candidates_for(sensors: Characteristics) -> list[Candidate]:
    """Return the candidates for such sensors, the preferred first."""
    lost = LOST_AFTER * sensors.s2_interval + sensors.s2_delivery
    patient = max(lost, 2.0 * sensors.s2_gap + sensors.s2_delivery)
    return [
        Candidate("s2", "S2 as it comes", _alone(0.0, patient)),
        Candidate("s1", "S1 as it comes", _alone(1.0, lost)),
        Candidate("conditioned", "S1 conditioned, alone", _conditioned(sensors, lost)),
        Candidate("full", "S1 conditioned, then the rules", _full(sensors, lost)),
        Candidate("aggregator", "the paper's rules, S1 as it comes", _aggregator(sensors, lost)),
    ]


def _alone(weight: float, timeout: float) -> FitSpec:
    space = _space((), {**_weights(*[weight] * 4), **_NO_CONDITIONING, "s2.timeout": timeout})
    return FitSpec(space, ({},), {}, 0.0, Evaluations(1, 1, 1))


def _aggregator(sensors: Characteristics, lost: float) -> FitSpec:
    space = _space(aggregator_axes(sensors), {**_NO_CONDITIONING, "s2.timeout": lost})
    starts = (_weights(0.9, 0.9, 0.98, 0.98), _weights(0.02, 0.05, 0.3, 0.7))
    return FitSpec(space, starts, _PLAIN_RULES, 0.01, _evaluations("aggregator", sensors))


def _conditioned(sensors: Characteristics, lost: float) -> FitSpec:
    interval = sensors.s2_interval
    space = _space(
        filter_axes(sensors),
        {
            **_weights(1.0, 1.0, 1.0, 1.0),
            **_NO_CONDITIONING,
            "s1.bias_moving_share": 1.0,
            "s2.timeout": lost,
        },
    )
    starts = [
        {"s1.bias_time_constant": 10.0 * interval},
        {"s1.bias_time_constant": 0.3 * interval},
        {
            "s1.bias_time_constant": 30.0 * interval,
            "s1.lowpass_time_constant": 30.0 * sensors.s1_interval,
        },
    ]
    return FitSpec(
        space, starts, {"s1.lowpass_time_constant": 0.0}, 0.01, _evaluations("conditioned", sensors)
    )


def _full(sensors: Characteristics, lost: float) -> FitSpec:
    space = _space(
        [*aggregator_axes(sensors), *filter_axes(sensors), *learning_axes(sensors)],
        {**_NO_CONDITIONING, "s2.timeout": lost},
    )
    home = {
        **_PLAIN_RULES,
        **_weights(1.0, 0.9, 1.0, 1.0),
        **_NO_SLOPES,
        "s1.lowpass_time_constant": 0.0,
        "s1.bias_moving_share": 0.1,
    }
    return FitSpec(space, _full_starts(sensors), home, 0.04, _evaluations("full", sensors))


def _full_starts(sensors: Characteristics) -> list[dict[str, float]]:
    interval, rate = sensors.s2_interval, sensors.rate
    on, all_s1 = _weights(0.9, 0.9, 0.98, 0.98), _weights(1.0, 1.0, 1.0, 1.0)
    bias, share, drift = "s1.bias_time_constant", "s1.bias_moving_share", "s1.drift_time_constant"
    return [
        {**on, **_NO_SLOPES, share: 0.1, bias: 10.0 * interval},
        {**all_s1, **_NO_SLOPES, share: 0.9, bias: 0.3 * interval},
        {
            **all_s1,
            share: 0.9,
            "s1.lowpass_time_constant": 30.0 * sensors.s1_interval,
            "s1.trend_time_constant": 10.0 * sensors.s1_interval,
            drift: 10.0,
            bias: 30.0 * interval,
        },
        {**all_s1, **_NO_SLOPES, share: 0.5, bias: 5.0 * interval, drift: 2.0},
        {
            **all_s1,
            **_NO_SLOPES,
            share: 0.3,
            "aggregator.rate.large": 0.2 * rate,
            "aggregator.rate_time_constant": 2.0 * interval,
            bias: 5.0 * interval,
            drift: 2.0,
        },
        {
            **on,
            **_NO_SLOPES,
            share: 0.05,
            "aggregator.rate.large": 0.1 * rate,
            "aggregator.rate_time_constant": interval,
            bias: 20.0 * interval,
            drift: 10.0,
        },
    ]


def _space(axes: Sequence[Axis], fixed: Mapping[str, float]) -> Space:
    return space_of(Parameters, axes, fixed)


def _evaluations(name: str, sensors: Characteristics) -> Evaluations:
    samples = sensors.span / sensors.s1_interval
    share = max(FEWEST, min(1.0, LONG / samples))
    return Evaluations(*(round(share * each) for each in EVALUATIONS[name]))


def _weights(*levels: float) -> dict[str, float]:
    return {f"aggregator.weight.{each}": level for each, level in zip(WEIGHTS, levels, strict=True)}


_NO_SLOPES = {"s1.trend_time_constant": NEVER, "s1.drift_time_constant": NEVER}
"""Neither the low-pass nor the bias has a slope."""

_PLAIN_RULES = {
    "aggregator.drift.large": 0.0,
    "aggregator.difference.small": 0.0,
    "aggregator.rate.small": 0.0,
}
"""Rules without drift whose ramps begin at 0."""

_NO_CONDITIONING = {
    "aggregator.drift.small": 0.0,
    "aggregator.drift.large": 0.0,
    "s1.spike_threshold": 0.0,
    "s1.lowpass_time_constant": 0.0,
    "s1.trend_time_constant": 0.0,
    "s1.bias_time_constant": 0.0,
    "s1.bias_moving_share": 0.0,
    "s1.drift_time_constant": 0.0,
    "s2.lag_time_constant": 0.0,
    "s2.delay": 0.0,
}
"""No conditioning of S1, and no drift."""
