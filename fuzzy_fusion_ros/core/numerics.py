# SPDX-License-Identifier: Apache-2.0
"""Small numerics that every step shares: intervals of time, bounds, the exact first-order lag."""

from __future__ import annotations

import math

SECOND_NS = 1_000_000_000

LARGEST = 1e100
"""Differences, quotients and squares of numbers within this bound stay finite."""


def seconds_between(earlier_ns: int, later_ns: int) -> float:
    """Return ``later_ns - earlier_ns`` in seconds; the difference is exact before it is scaled."""
    return (later_ns - earlier_ns) * 1e-9


def clamped(x: float, low: float, high: float) -> float:
    """Return ``x``, or the bound that it exceeds; infinities are clamped, NaN passes.

    Written out because it runs several times a sample, and calls of ``min`` and ``max`` would
    cost as much as the rest of the aggregator.
    """
    if x < low:
        return low
    if x > high:
        return high
    return x


def bounded(x: float) -> float:
    """Return ``x`` within ``LARGEST``."""
    return clamped(x, -LARGEST, LARGEST)


def lag_gain(dt: float, time_constant: float) -> float:
    """Return ``1 - exp(-dt / time_constant)``, the step response of a first-order lag.

    A time constant of 0 gives 1.
    """
    if time_constant <= 0.0:
        return 1.0
    return 1.0 - math.exp(-dt / time_constant)
