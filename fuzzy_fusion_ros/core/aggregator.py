# SPDX-License-Identifier: Apache-2.0
"""The fuzzy aggregator (FA): weight and drift from ``|S1 - S2|`` and ``|dS2/dt|``."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.core.numerics import bounded, clamped, seconds_between
from fuzzy_fusion_ros.core.silence import S2_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters, BreakPoints


class SlowSensor(NamedTuple):
    """What is kept of S2: its newest sample, held, and the rate it has shown.

    Attributes:
        samples: Samples seen since the last start.
        stamp_ns: Stamp of the newest sample, nanoseconds.
        value: The newest sample, unit of the signal.
        rate: Filtered dS2/dt, unit of the signal per second.
        interval: Time between samples, followed, seconds; 0 before the second.
    """

    samples: int
    stamp_ns: int
    value: float
    rate: float
    interval: float = 0.0


class FiringStrengths(NamedTuple):
    """How much each rule of Table 1 fires, in its order: difference, then rate; they sum to 1."""

    small_small: float
    small_large: float
    large_small: float
    large_large: float


class Aggregate(NamedTuple):
    """Output of the aggregator.

    Attributes:
        value: FA's output, unit of the signal.
        weight: W1, the weight of S1, 0 to 1.
        drift: Magnitude of the drift, unit of the signal.
        strengths: The four firing strengths behind both.
    """

    value: float
    weight: float
    drift: float
    strengths: FiringStrengths


def no_slow_sensor() -> SlowSensor:
    """Return the state before any S2 sample."""
    return SlowSensor(samples=0, stamp_ns=0, value=0.0, rate=0.0, interval=0.0)


def observe_slow(
    time_constant: float, timeout: float, s2: SlowSensor, stamp_ns: int, value: float
) -> SlowSensor:
    """Take a new S2 sample and move the rate.

    ``rate_k = (T_r rate_{k-1} + S2_k - S2_{k-1}) / (T_r + dt)`` over the actual
    stamp difference. The first sample, also the first after a gap, shows no rate.

    Args:
        time_constant: ``T_r``, seconds, 0 or more.
        timeout: Longest time between two samples that still show a rate, seconds; 0 is automatic.
        s2: The state so far.
        stamp_ns: Stamp of the sample, later than that of the last one.
        value: The sample, finite.
    """
    rate = 0.0
    interval = 0.0
    dt = seconds_between(s2.stamp_ns, stamp_ns)
    if s2.samples > 0:
        interval = followed(s2.interval, dt)
    if s2.samples > 0 and dt <= timeout_for(timeout, S2_TIMEOUT, s2.interval):
        rate = (time_constant * s2.rate + (value - s2.value)) / (time_constant + dt)
        rate = bounded(rate)
    return SlowSensor(s2.samples + 1, stamp_ns, value, rate, interval)


def firing_strengths(
    difference: float, rate: float, difference_ramp: BreakPoints, rate_ramp: BreakPoints
) -> FiringStrengths:
    """Table 1's left side: product inference over the two inputs, both non-negative."""
    d = large(difference, difference_ramp)
    r = large(rate, rate_ramp)
    near = 1.0 - d
    slow = 1.0 - r
    return FiringStrengths(near * slow, near * r, d * slow, d * r)


def defuzzify(
    strengths: FiringStrengths,
    small_small: float,
    small_large: float,
    large_small: float,
    large_large: float,
) -> float:
    """Centre-average defuzzifier over singletons; the strengths sum to 1 but for rounding."""
    return (
        strengths.small_small * small_small
        + strengths.small_large * small_large
        + strengths.large_small * large_small
        + strengths.large_large * large_large
    )


def blend(weight: float, s1: float, s2: float) -> float:
    """Eq. (1) with normalised weights: between S1 and S2, whatever the rounding."""
    value = weight * s1 + (1.0 - weight) * s2
    if s1 < s2:
        return clamped(value, s1, s2)
    return clamped(value, s2, s1)


def sign(x: float) -> float:
    """Return -1, 0 or 1."""
    if x > 0.0:
        return 1.0
    if x < 0.0:
        return -1.0
    return 0.0


def aggregate(parameters: AggregatorParameters, s1: float, s2: float, rate: float) -> Aggregate:
    """Fig. 3: the rule base, then eq. (1) and the drift.

    Args:
        parameters: Break points, weights and drift levels.
        s1: S1, finite.
        s2: S2, finite, held.
        rate: dS2/dt, finite.

    Returns:
        Finite numbers; ``value`` lies between S1 and S2, moved by at most the drift.
    """
    strengths = firing_strengths(abs(s1 - s2), abs(rate), parameters.difference, parameters.rate)
    levels = parameters.weight
    weight = defuzzify(strengths, levels.small, levels.large, levels.very_small, levels.very_large)
    step = parameters.drift
    drift = defuzzify(strengths, step.small, step.large, step.small, step.small)
    value = blend(weight, s1, s2) + sign(rate) * drift
    return Aggregate(value, clamped(weight, 0.0, 1.0), drift, strengths)


def single(value: float, weight: float) -> Aggregate:
    """Return one sensor alone as the aggregate, for when the other is lost.

    Args:
        value: The sensor that is left.
        weight: W1 to show for it, 1 for S1 and 0 for S2.
    """
    silent = FiringStrengths(small_small=0.0, small_large=0.0, large_small=0.0, large_large=0.0)
    return Aggregate(value=value, weight=weight, drift=0.0, strengths=silent)
