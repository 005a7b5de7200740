# SPDX-License-Identifier: Apache-2.0
"""Adaptation while it runs: of S2's lag, and of the scale of S1. Our extension, off by default.

Both are factors, 1 at first: one of the lag and the delay of S2's model, one of S1's movements.
Each has a twin: an observer whose factor is larger by ``APART``, corrected with the same gains.
What the twin's innovation is more than ours says what a change of the factor would make of ours,
so it is the gradient of the recursive prediction error method. The factor follows it by recursive
least squares, which forget with the time constant given. Where a plausible change would not show
in what innovations usually are, nothing is learnt and nothing is forgotten: while S1 rests, and
while S2 is silent. A change of a factor is one of its logarithm: twice is as far as half.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.covariance import Gain
from fuzzy_fusion_ros.core.model import (
    Lagged,
    States,
    carried,
    corrected_states,
    lag_gains,
    no_states,
    shifted_states,
    shown_at,
    shown_on,
)
from fuzzy_fusion_ros.core.numerics import LARGEST, bounded, clamped, lag_gain
from fuzzy_fusion_ros.parameters.fusion import AdaptParameters, SlowSensorParameters

APART = 1.1
"""A twin's factor is this many times the observer's."""

STEP = math.log(APART)

LAG_DEVIATION, SCALE_DEVIATION = 0.7, 0.25
"""How far the logarithm of a factor may plausibly be off."""

LARGEST_LAG, LARGEST_SCALE = 5.0, 2.0
"""Factors are within these and their inverses."""

VISIBLE = 1.0
"""A plausible change has to show by this many standard deviations of an innovation."""

FIRST = 10.0
"""At first as much is known of a factor as that many innovations say which just show it."""

REPLACED = 10.0
"""A sample makes at most this many times what it says be forgotten: one of noise, next to nothing.
"""

OUTLIER = 3.0
"""An innovation counts as at most this many of its standard deviations."""

LARGEST_CHANGE = 20.0
"""Of a factor's logarithm at a time: far beyond all bounds of factors, and finite as a factor."""


class Factor(NamedTuple):
    """A factor that is adapted.

    Attributes:
        is_on: Whether its twin runs.
        value: The factor.
        information: Sum of the squared gradients that it was learnt from, less what is forgotten;
            0 before any.
        twin: The observer with a larger factor.
    """

    is_on: bool
    value: float
    information: float
    twin: States


class Adaptation(NamedTuple):
    """What is adapted: the factor of S2's lag and delay, and that of S1's movements."""

    lag: Factor
    scale: Factor


def no_adaptation() -> Adaptation:
    """Return what is kept while nothing is adapted."""
    none = Factor(False, 1.0, 0.0, no_states())
    return Adaptation(none, none)


def adapts(parameters: AdaptParameters, kept: Adaptation) -> bool:
    """Return whether anything is adapted, or has been until now."""
    wanted = parameters.lag_time_constant > 0.0 or parameters.scale_time_constant > 0.0
    return wanted or kept.lag.is_on or kept.scale.is_on


def paused(kept: Adaptation) -> Adaptation:
    """Return it with twins that begin again at the next sample of S1; the factors stay."""
    lag, scale = kept.lag, kept.scale
    return Adaptation(
        Factor(False, lag.value, lag.information, lag.twin),
        Factor(False, scale.value, scale.information, scale.twin),
    )


def switched(parameters: AdaptParameters, kept: Adaptation, own: States, s1: float) -> Adaptation:
    """Let twins begin, and end, as the parameters say; a factor that ends stays as it is.

    Args:
        parameters: What is adapted.
        kept: The twins so far.
        own: The observer itself.
        s1: S1, conditioned. The twin of the scale begins with the same estimate: its bias takes
            what its scale makes of S1.
    """
    lag, scale = kept.lag, kept.scale
    wanted = parameters.lag_time_constant > 0.0
    if lag.is_on != wanted:
        lag = Factor(wanted, lag.value, lag.information, own)
    wanted = parameters.scale_time_constant > 0.0
    if scale.is_on != wanted:
        more = (APART - 1.0) * scale.value
        behind, was = more * own.shown.lagged, own.through
        through = Lagged(bounded(was.first + behind), bounded(was.second + behind))
        twin = States(bounded(own.bias + more * s1), own.slope, through, own.shown)
        scale = Factor(wanted, scale.value, scale.information, twin)
    return Adaptation(lag, scale)


def twins_on(
    parameters: SlowSensorParameters,
    kept: Adaptation,
    dt: float,
    stamp_ns: int,
    s1: float,
    reach: float,
) -> Adaptation:
    """Move the twins on to a sample of S1.

    Args:
        parameters: Of S2.
        kept: The twins so far.
        dt: Time since the last sample, seconds.
        stamp_ns: Stamp of the sample.
        s1: S1 with it, conditioned.
        reach: How far back samples of S2 look, seconds.
    """
    lag, scale = kept.lag, kept.scale
    if lag.is_on:
        first, second = lag_gains(parameters, APART * lag.value, dt)
        shown = shown_on(lag.twin.shown, first, stamp_ns, s1, APART * reach)
        twin = carried(lag.twin, shown, dt, first, second)
        lag = Factor(True, lag.value, lag.information, twin)
    if scale.is_on:
        first, second = lag_gains(parameters, lag.value, dt)
        twin = carried(scale.twin, scale.twin.shown, dt, first, second)
        scale = Factor(True, scale.value, scale.information, twin)
    return Adaptation(lag, scale)


class Confronted(NamedTuple):
    """A sample of S2 and what was expected of it.

    Attributes:
        s1_ns: Stamp of S1's newest sample.
        s2_ns: Stamp of the sample.
        s2: The sample.
        shown: S1 as S2 would show it, of scale 1.
        innovation: The observer's innovation.
        variance: Its variance, by what innovations have lately been, unit of the signal squared.
        interval: Usual time between samples of S2, seconds.
    """

    s1_ns: int
    s2_ns: int
    s2: float
    shown: float
    innovation: float
    variance: float
    interval: float


def adapted(
    parameters: AdaptParameters,
    sensor: SlowSensorParameters,
    kept: Adaptation,
    own: States,
    k: Gain,
    seen: Confronted,
) -> tuple[Adaptation, States]:
    """Let a sample of S2 correct the twins, and their innovations the factors.

    Where the scale changes, bias and slope change by what they would have been with it.

    Args:
        parameters: What is adapted, and how fast.
        sensor: Of S2.
        kept: The twins, moved on to S1's newest sample.
        own: The observer itself, corrected by the sample.
        k: The gain with which it was.
        seen: The sample.

    Returns:
        The twins and factors after it, and the observer.
    """
    lag, scale, left = kept.lag, kept.scale, seen.innovation
    if lag.is_on:
        shown = shown_at(sensor, APART * lag.value, lag.twin.shown, seen.s1_ns, seen.s2_ns)
        innovation = bounded(scale.value * shown - lag.twin.through.second - seen.s2)
        slope = (innovation - seen.innovation) / STEP
        twin = corrected_states(lag.twin, lag.twin.shown, k, innovation)
        information, change = learnt(
            parameters.lag_time_constant, LAG_DEVIATION, lag.information, slope, left, seen
        )
        value = clamped(lag.value * math.exp(change), 1.0 / LARGEST_LAG, LARGEST_LAG)
        lag = Factor(True, value, information, twin)
        left += slope * change
    if scale.is_on:
        innovation = bounded(APART * scale.value * seen.shown - scale.twin.through.second - seen.s2)
        slope = (innovation - seen.innovation) / STEP
        twin = corrected_states(scale.twin, scale.twin.shown, k, innovation)
        information, change = learnt(
            parameters.scale_time_constant, SCALE_DEVIATION, scale.information, slope, left, seen
        )
        value = clamped(scale.value * math.exp(change), 1.0 / LARGEST_SCALE, LARGEST_SCALE)
        share = math.log(value / scale.value) / STEP
        scale = Factor(True, value, information, shifted_states(twin, own, twin, share))
        own = shifted_states(own, own, twin, share)
    return Adaptation(lag, scale), own


def learnt(
    time_constant: float,
    deviation: float,
    information: float,
    slope: float,
    innovation: float,
    seen: Confronted,
) -> tuple[float, float]:
    """Return what is known of a factor's logarithm after a sample of S2, and how far it changes.

    Args:
        time_constant: With which it is forgotten, seconds.
        deviation: How far the logarithm may plausibly be off.
        information: What was known: the sum of the squares of slopes.
        slope: What a change of the logarithm by 1 adds to the innovation, unit of the signal.
        innovation: What is left of it to explain.
        seen: The sample.
    """
    plausible = seen.variance / (deviation * deviation)
    squared = min(slope * slope, LARGEST)
    if time_constant <= 0.0 or not squared > VISIBLE * VISIBLE * plausible > 0.0:
        return information, 0.0
    forgotten = min(lag_gain(seen.interval, time_constant) * information, REPLACED * squared)
    kept = max(information - forgotten, plausible) if information > 0.0 else FIRST * plausible
    most = OUTLIER * math.sqrt(seen.variance)
    change = -slope * clamped(innovation, -most, most) / (kept + squared)
    return kept + squared, clamped(change, -LARGEST_CHANGE, LARGEST_CHANGE)
