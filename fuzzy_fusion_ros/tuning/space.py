# SPDX-License-Identifier: Apache-2.0
"""Parameters as points of the unit cube in which the optimiser moves."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.lag import TRUSTED, Lag
from fuzzy_fusion_ros.core.numerics import clamped
from fuzzy_fusion_ros.parameters.group import Descriptor, Group, descriptors, flatten, within
from fuzzy_fusion_ros.self_tuning import homes
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics

Follow = Callable[[Mapping[str, float]], Mapping[str, float]]

TIMES = ("s1.lowpass_time_constant", "s2.lag_time_constant", "s2.delay")
"""What the sensors determine; other axes may well be best at an end, where a part is off."""

AT_LIMIT = 0.01
"""This share of an axis is its end: least squares approach it but do not reach it."""

LOWEST = 1e-12
"""Lowest value on a logarithmic axis."""


class Axis(NamedTuple):
    """A parameter that a fit moves.

    Attributes:
        name: Its dotted name.
        low: Smallest value, or factor.
        high: Largest value, or factor.
        usual: Where a fit starts by default, and where it is drawn to.
        logarithmic: Whether the scale is logarithmic.
        share_of: The parameter of which values are a share; empty for none.
        doubt: Whether the axis is of a factor ``1 / (1 - value)``: a weight of S1 as the factor
            by which S2's noise counts.
        pull: Cost of a squared decade of distance from the usual value, or of the squared axis
            if it is not logarithmic, as a share of the misfit.
    """

    name: str
    low: float
    high: float
    usual: float
    logarithmic: bool = True
    share_of: str = ""
    doubt: bool = False
    pull: float = 0.0

    def place(self, value: float) -> float:
        """Return the place of a value on the axis, 0 to 1; values beyond an end are at that end."""
        if self.doubt:
            value = 1.0 / max(1.0 - value, TINY)
        inside = clamped(value, self.low, self.high)
        if self.low >= self.high:
            return 0.0
        if self.logarithmic:
            return math.log(inside / self.low) / math.log(self.high / self.low)
        return (inside - self.low) / (self.high - self.low)

    def value(self, place: float) -> float:
        """Return the value at a place, 0 to 1."""
        if self.logarithmic:
            value = float(self.low * (self.high / self.low) ** place)
        else:
            value = float(self.low + (self.high - self.low) * place)
        return 1.0 - 1.0 / value if self.doubt else value

    @property
    def length(self) -> float:
        """Decades from end to end; 1 if the scale is not logarithmic."""
        return math.log10(self.high / self.low) if self.logarithmic else 1.0


class Space(NamedTuple):
    """The parameters that a fit moves, and those that it sets; made by :func:`space_of`.

    Attributes:
        axes: Those that are moved.
        fixed: Values of those that are set, by dotted name.
        limits: What may be moved and set, by dotted name.
        follow: Gives what follows from the parameters moved and set, by dotted name.
    """

    axes: Sequence[Axis]
    fixed: Mapping[str, float]
    limits: Mapping[str, Descriptor]
    follow: Follow

    def away(self, point: Reals) -> float:
        """Return the cost of being away from the usual values, as a share of the misfit."""
        pulls = [each.pull * each.length**2 for each in self.axes]
        usual = [each.place(each.usual) for each in self.axes]
        return float(np.dot(pulls, np.square(point - usual)))

    def point(self, values: Mapping[str, float]) -> Reals:
        """Return the point of the given values; others are at their usual value.

        Args:
            values: By dotted name; shares as shares.
        """
        return np.array([each.place(values.get(each.name, each.usual)) for each in self.axes])

    def point_of(self, parameters: Group) -> Reals:
        """Return the point of parameters: the inverse of :meth:`values`."""
        known = {
            name: float(value)
            for name, value in flatten(parameters).items()
            if isinstance(value, int | float)
        }
        whole = {**known, "": 1.0}
        shares = {
            each.name: known[each.name] / max(whole[each.share_of], TINY) for each in self.axes
        }
        return self.point(shares)

    def at_limit(self, parameters: Group) -> tuple[str, ...]:
        """Return which of S1's low-pass and S2's lag are as long as may be: they may be longer."""
        places = zip(self.axes, self.point_of(parameters), strict=True)
        return tuple(
            each.name for each, place in places if each.name in TIMES and place > 1.0 - AT_LIMIT
        )

    def values(self, point: Reals) -> dict[str, float]:
        """Return the parameters at a point by dotted name, including those that are set."""
        return {**within(self.limits, self.fixed), **self.moved(point)}

    def moved(self, point: Reals) -> dict[str, float]:
        """Return the parameters at a point by dotted name, without those that are only set."""
        moved = {
            each.name: each.value(float(place))
            for each, place in zip(self.axes, point, strict=True)
        }
        for each in self.axes:
            if each.share_of:
                moved[each.name] *= moved[each.share_of]
        return within(self.limits, {**moved, **self.follow({**self.fixed, **moved})})


def nothing_follows(values: Mapping[str, float]) -> Mapping[str, float]:
    """Return no parameters."""
    return {}


def space_of(
    kind: type[Group],
    axes: Sequence[Axis],
    fixed: Mapping[str, float],
    follow: Follow = nothing_follows,
) -> Space:
    """Return the space of a group's parameters, every value within what the group allows.

    Args:
        kind: The group.
        axes: What is moved; an axis that reaches beyond the limits of its parameter ends there.
        fixed: What is set, by dotted name.
        follow: What follows from both, by dotted name; nothing unless given.
    """
    limits = {name: descriptor for name, descriptor, _ in descriptors(kind)}
    return Space([_within(limits[each.name], each) for each in axes], fixed, limits, follow)


def _within(limits: Descriptor, axis: Axis) -> Axis:
    if axis.share_of or axis.doubt:
        return axis
    low = max(limits.low, LOWEST) if axis.logarithmic else limits.low
    return axis._replace(
        low=clamped(axis.low, low, limits.high), high=clamped(axis.high, low, limits.high)
    )


WEIGHTS = ("very_small", "small", "large", "very_large")
"""Levels of Table 1, in its order."""

LAGS = ("s2.lag_time_constant", "s2.delay")
"""S2's model."""

SURE = 0.9
"""At this correlation and above, the lag is measured rather than estimated."""


def aggregator_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of the paper's rules; each weight is a share of the next larger one."""
    large, small = "aggregator.weight.large", "aggregator.weight.small"
    pull = 0.01
    return [
        *_ramp("aggregator.difference", 0.03, sensors.difference),
        *_ramp("aggregator.rate", 0.01, sensors.rate),
        _around(
            "aggregator.rate_time_constant",
            homes.rate_time_constant(sensors.s2_interval),
            0.1,
            100.0,
            pull,
        ),
        Axis("aggregator.weight.very_large", 0.0, 1.0, 0.8, False, pull=pull),
        Axis(large, 0.0, 1.0, 0.7, False, "aggregator.weight.very_large", pull=pull),
        Axis(small, 0.0, 1.0, 0.5, False, large, pull=pull),
        Axis("aggregator.weight.very_small", 0.0, 1.0, 0.3, False, small, pull=pull),
        Axis(
            "aggregator.drift.large",
            0.0,
            4.0 * sensors.difference,
            0.0,
            logarithmic=False,
            pull=pull,
        ),
    ]


def bias_axes(sensors: Characteristics, bias_time: float) -> list[Axis]:
    """Return the axes of S1's low-pass, spikes and bias, and of S2's lag.

    Each is drawn towards what the sensors are like: S2's lag as measured, the more so the surer
    that is; a bias that walks as far as S1 was seen to.

    Args:
        sensors: What the sensors are like.
        bias_time: As from :func:`usual_bias_time`, seconds.
    """
    shortest = 0.1 * sensors.s1_interval
    found = trusted(sensors)
    lag = max(found.total, sensors.s1_interval)
    longest = max(3.0 * lag, 1.0, 2.0 * shortest)
    sure = 0.06 if sensors.lag.correlation > SURE and not sensors.lag_at_limit else 0.02
    wander = bias_wander(sensors)
    axes = [
        Axis(
            "s1.lowpass_time_constant",
            shortest,
            max(300.0 * sensors.s1_interval, sensors.s2_interval),
            2.0 * sensors.s1_interval,
            pull=0.01,
        ),
        Axis(
            "s2.lag_time_constant",
            shortest,
            longest,
            max(found.time_constant, 0.3 * lag),
            pull=sure,
        ),
        Axis(
            "s2.delay",
            shortest,
            longest,
            max(found.delay, 0.05 * lag),
            pull=sure / 2.0,
        ),
        _around("s1.bias_time_constant", bias_time, 1e-3, 1e3, 0.0025),
        _around("s1.bias_prior", wander, 0.01, 100.0, 0.01),
    ]
    if sensors.has_spikes:
        scale = max(sensors.spike_scale, TINY)
        axes.append(_around("s1.spike_threshold", homes.spike_threshold(scale), 0.25, 100.0, 0.02))
    return axes


def noise_axis(sensors: Characteristics) -> Axis:
    """Return the axis of S2's noise, which has a unit only where innovations are to have one."""
    return _around("s2.noise", sensors.s2_noise, 0.3, 300.0, 0.0)


def trusted(sensors: Characteristics) -> Lag:
    """Return the lag to start a fit from, or none where that is not to be trusted.

    It need not be identifiable as S2's: a fit bridges whatever time is between the stamps, also
    that between two clocks, and the longest lag searched for is nearer to a longer one than none.
    """
    lag = sensors.lag
    is_measured = lag.correlation >= TRUSTED and not sensors.moves_one_way
    return lag if is_measured else Lag(0.0, 0.0, lag.correlation)


def has_lag_to_fit(sensors: Characteristics) -> bool:
    """Return whether a fit without a truth moves the lag: it is sure, or a lower bound only."""
    enough = TRUSTED if sensors.lag_at_limit else SURE
    return sensors.lag.correlation >= enough and not sensors.moves_one_way


def slope_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of the slope of S1's bias: how it changes, and how far it may be from 0."""
    return [
        _around("s1.drift_time_constant", 3.0 * sensors.span, 1e-4, 1e4, 0.005),
        _around("s1.drift_prior", usual_slope(sensors), 0.01, 100.0, 0.01),
    ]


def rule_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of Table 1 in the observer: how far S2 is doubted in motion, and when."""
    return [
        Axis("aggregator.weight.large", 1.0, 100.0, homes.DOUBT_IN_MOTION, doubt=True, pull=0.02),
        _around("aggregator.rate.large", sensors.rate, 0.01, 30.0, 0.01),
    ]


def very_large(values: Mapping[str, float]) -> Mapping[str, float]:
    """Return the largest weight of Table 1, which follows from the one before it."""
    large = values["aggregator.weight.large"]
    return {"aggregator.weight.very_large": homes.very_large(large)}


def bias_wander(sensors: Characteristics) -> float:
    """Return how far S1's bias scatters, no less than can be distinguished from S2's noise."""
    return max(sensors.wander, sensors.s2_noise)


def usual_slope(sensors: Characteristics) -> float:
    """Return how steeply S1's bias was seen to drift, no less than its scatter could hide."""
    return max(abs(sensors.drift), bias_wander(sensors) / sensors.span)


def usual_bias_time(sensors: Characteristics, has_slope: bool) -> float:
    """Return the time constant of a bias that walks as far as S1's was seen to, seconds.

    Args:
        sensors: What the sensors are like.
        has_slope: Whether a steady drift is a slope of its own and no part of the walk.
    """
    walk = bias_wander(sensors) / math.sqrt(sensors.span)
    if not has_slope:
        walk = max(walk, abs(sensors.drift))
    return sensors.s2_noise * math.sqrt(sensors.s2_interval) / walk


def _ramp(name: str, reach_down: float, scale: float) -> list[Axis]:
    large = f"{name}.large"
    return [
        _around(large, scale, reach_down, 30.0, 0.005),
        Axis(f"{name}.small", 0.0, 0.95, 0.0, logarithmic=False, share_of=large, pull=0.01),
    ]


def _around(name: str, usual: float, reach_down: float, reach_up: float, pull: float) -> Axis:
    return Axis(name, reach_down * usual, reach_up * usual, usual, pull=pull)
