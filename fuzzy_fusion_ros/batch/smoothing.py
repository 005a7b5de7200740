# SPDX-License-Identifier: Apache-2.0
"""Filters over whole series with uneven stamps."""

from __future__ import annotations

import math

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.core.numerics import lag_gain

_SPANS_A_LINE = 1e-3
"""Points whose spread is a smaller share than this of their distance determine no slope."""


def lagged(time_s: Reals, values: Reals, time_constant: float) -> Reals:
    """Return a series passed through a first-order lag that starts at the first value.

    Args:
        time_s: Times, rising, shape (n,), seconds.
        values: Shape (n,).
        time_constant: Seconds; 0 is no lag.
    """
    found = np.empty_like(values)
    compiled(_lagged)(time_s, values, time_constant, found)
    return found


def smoothed(
    time_s: Reals, values: Reals, time_constant: float, straight: bool = False, hole: float = -1.0
) -> Reals:
    """Return a series smoothed without delay: a local mean, or a local line, at each sample.

    Neighbours on either side have the weight ``exp(-|distance| / time_constant)``.

    Args:
        time_s: Times, rising, shape (n,), seconds.
        values: Shape (n,).
        time_constant: Seconds, more than 0.
        straight: Whether to fit a line; where the points determine none, it is the mean.
        hole: Samples up to this far away, the sample itself included, have no weight; negative:
            all have. Where none is left, the sample itself is returned.
    """
    found = np.empty_like(values)
    before = np.zeros((values.size, 5))
    after = np.zeros((values.size, 5))
    compiled(_smoothed)(time_s, values, time_constant, straight, hole, before, after, found)
    return found


def _lagged(time_s: Reals, values: Reals, time_constant: float, found: Reals) -> None:
    found[0] = values[0]
    for k in range(1, values.size):
        gain = lag_gain(time_s[k] - time_s[k - 1], time_constant)
        found[k] = found[k - 1] + gain * (values[k] - found[k - 1])


def _smoothed(
    time_s: Reals,
    values: Reals,
    time_constant: float,
    straight: bool,
    hole: float,
    before: Reals,
    after: Reals,
    found: Reals,
) -> None:
    """Smooth in one pass each way, with weighted sums of 1, u, u^2, x, u x about each sample."""
    n = values.size
    for k in range(n):
        if k > 0:
            step = time_s[k] - time_s[k - 1]
            _shift(before[k - 1], -step, math.exp(-step / time_constant), before[k])
        before[k, 0] += 1.0
        before[k, 3] += values[k]
    for k in range(n - 1, -1, -1):
        if k < n - 1:
            step = time_s[k + 1] - time_s[k]
            _shift(after[k + 1], step, math.exp(-step / time_constant), after[k])
        after[k, 0] += 1.0
        after[k, 3] += values[k]
    last = -1
    first = 0
    total = np.zeros(5)
    side = np.zeros(5)
    for k in range(n):
        if hole < 0.0:
            total[:] = before[k] + after[k]
            total[0] -= 1.0
            total[3] -= values[k]
        else:
            while last + 1 < n and time_s[last + 1] < time_s[k] - hole:
                last += 1
            while first < n and time_s[first] <= time_s[k] + hole:
                first += 1
            past = time_s[k] - time_s[last] if last >= 0 else math.inf
            future = time_s[first] - time_s[k] if first < n else math.inf
            nearest = min(past, future)
            total[:] = 0.0
            if last >= 0:
                _shift(before[last], -past, math.exp(-(past - nearest) / time_constant), side)
                total += side
            if first < n:
                _shift(after[first], future, math.exp(-(future - nearest) / time_constant), side)
                total += side
        found[k] = _at_centre(total, straight, values[k])


def _shift(sums: Reals, distance: float, decay: float, shifted: Reals) -> None:
    """Write sums about a place from which the points are ``distance`` further away."""
    one, u, uu, x, ux = sums
    shifted[0] = decay * one
    shifted[1] = decay * (u + distance * one)
    shifted[2] = decay * (uu + 2.0 * distance * u + distance * distance * one)
    shifted[3] = decay * x
    shifted[4] = decay * (ux + distance * x)


def _at_centre(sums: Reals, straight: bool, otherwise: float) -> float:
    one, u, uu, x, ux = sums
    if one <= 0.0:
        return otherwise
    spread = uu * one - u * u
    if straight and spread > _SPANS_A_LINE * uu * one:
        return float((uu * x - u * ux) / spread)
    return float(x / one)
