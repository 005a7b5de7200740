"""Parameters as points of the unit cube in which the optimiser moves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.core.numerics import clamped
from fuzzy_fusion_ros.parameters.group import Descriptor, Group, descriptors
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics

NEVER = 1e9
"""Above every axis: at its upper end, a time constant makes its step nearly ineffective."""

LOWEST = 1e-12
"""Lowest value on a logarithmic axis."""

SLOPE_OVER_BIAS = 2.0
"""A slope's time constant is at least twice its bias's, as in the steady Kalman filter of a bias
whose slope is a random walk; with less, the learnt bias oscillates."""


class Axis(NamedTuple):
    """A parameter that a fit moves.

    Attributes:
        name: Its dotted name.
        low: Smallest value.
        high: Largest value.
        usual: Where a fit starts by default.
        logarithmic: Whether the scale is logarithmic.
        share_of: The parameter of which values are a share; empty for none.
    """

    name: str
    low: float
    high: float
    usual: float
    logarithmic: bool = True
    share_of: str = ""

    def place(self, value: float) -> float:
        """Return the place of a value on the axis, 0 to 1; values beyond an end are at that end."""
        inside = clamped(value, self.low, self.high)
        if self.low >= self.high:
            return 0.0
        if self.logarithmic:
            return math.log(inside / self.low) / math.log(self.high / self.low)
        return (inside - self.low) / (self.high - self.low)

    def value(self, place: float) -> float:
        """Return the value at a place, 0 to 1."""
        if self.logarithmic:
            return float(self.low * (self.high / self.low) ** place)
        return float(self.low + (self.high - self.low) * place)


class Space(NamedTuple):
    """The parameters that a fit moves, and those that it sets; made by :func:`space_of`.

    Attributes:
        axes: Those that are moved.
        fixed: Values of those that are set, by dotted name.
        limits: What may be moved and set, by dotted name.
    """

    axes: Sequence[Axis]
    fixed: Mapping[str, float]
    limits: Mapping[str, Descriptor]

    def point(self, values: Mapping[str, float]) -> Reals:
        """Return the point of the given values; others are at their usual value.

        Args:
            values: By dotted name; shares as shares.
        """
        return np.array([each.place(values.get(each.name, each.usual)) for each in self.axes])

    def values(self, point: Reals) -> dict[str, float]:
        """Return the parameters at a point by dotted name, including those that are set."""
        moved = {
            each.name: each.value(float(place))
            for each, place in zip(self.axes, point, strict=True)
        }
        for each in self.axes:
            if each.share_of:
                moved[each.name] *= moved[each.share_of]
        return _allowed(self.limits, {**self.fixed, **moved})


def space_of(kind: type[Group], axes: Sequence[Axis], fixed: Mapping[str, float]) -> Space:
    """Return the space of a group's parameters, every value within what the group allows.

    Args:
        kind: The group.
        axes: What is moved; an axis that reaches beyond the limits of its parameter ends there.
        fixed: What is set, by dotted name.
    """
    limits = {name: descriptor for name, descriptor, _ in descriptors(kind)}
    return Space([_within(limits[each.name], each) for each in axes], fixed, limits)


def allowed(kind: type[Group], values: Mapping[str, float]) -> dict[str, float]:
    """Return values by dotted name, each moved to the nearest that the group allows."""
    return _allowed({name: descriptor for name, descriptor, _ in descriptors(kind)}, values)


def _allowed(limits: Mapping[str, Descriptor], values: Mapping[str, float]) -> dict[str, float]:
    return {
        name: clamped(value, limits[name].low, limits[name].high) for name, value in values.items()
    }


def _within(limits: Descriptor, axis: Axis) -> Axis:
    if axis.share_of:
        return axis
    low = max(limits.low, LOWEST) if axis.logarithmic else limits.low
    return axis._replace(
        low=clamped(axis.low, low, limits.high), high=clamped(axis.high, low, limits.high)
    )


WEIGHTS = ("very_small", "small", "large", "very_large")


def aggregator_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of the aggregator's rules."""
    usual = dict(zip(WEIGHTS, (0.1, 0.3, 0.6, 0.8), strict=True))
    return [
        *_ramp("aggregator.difference", 0.03, sensors.difference),
        *_ramp("aggregator.rate", 0.01, sensors.rate),
        _around("aggregator.rate_time_constant", 0.3 * sensors.s2_interval, 0.1, 100.0),
        *(Axis(f"aggregator.weight.{each}", 0.0, 1.0, usual[each], False) for each in WEIGHTS),
        Axis(
            "aggregator.drift.large",
            0.0,
            4.0 * sensors.difference,
            0.05 * sensors.difference,
            logarithmic=False,
        ),
    ]


def filter_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of S1's low-pass and bias, of S2's lag, and of spikes if there are any."""
    shortest = 0.1 * sensors.s1_interval
    lag = sensors.lag
    axes = [
        Axis(
            "s1.lowpass_time_constant",
            0.3 * sensors.s1_interval,
            max(300.0 * sensors.s1_interval, sensors.s2_interval),
            2.0 * sensors.s1_interval,
        ),
        Axis(
            "s1.bias_time_constant",
            0.03 * sensors.s2_interval,
            max(300.0 * sensors.s2_interval, 100.0),
            max(10.0 * sensors.s2_interval, 5.0),
        ),
        Axis(
            "s2.lag_time_constant",
            shortest,
            max(3.0 * lag.time_constant, 1.0, 2.0 * shortest),
            lag.time_constant,
        ),
        Axis("s2.delay", shortest, max(3.0 * lag.delay, 1.0, 2.0 * shortest), lag.delay),
    ]
    if sensors.has_spikes:
        scale = max(sensors.spike_scale, TINY)
        axes.append(Axis("s1.spike_threshold", 2.0 * scale, 1e3 * scale, 8.0 * scale))
    return axes


def learning_axes(sensors: Characteristics) -> list[Axis]:
    """Return the axes of what adapts the conditioning: quietness, drift and trend."""
    return [
        Axis("s1.bias_moving_share", 0.0, 1.0, 0.2, logarithmic=False),
        Axis(
            "s1.drift_time_constant", SLOPE_OVER_BIAS, 1e3, 10.0, share_of="s1.bias_time_constant"
        ),
        _around("s1.trend_time_constant", 100.0 * sensors.s1_interval, 0.01, 10.0),
    ]


def _ramp(name: str, reach_down: float, scale: float) -> list[Axis]:
    large = f"{name}.large"
    return [
        _around(large, scale, reach_down, 30.0),
        Axis(f"{name}.small", 0.0, 0.95, 0.1, logarithmic=False, share_of=large),
    ]


def _around(name: str, usual: float, reach_down: float, reach_up: float) -> Axis:
    return Axis(name, reach_down * usual, reach_up * usual, usual)
