"""Bounds: the arithmetic on out-of-range inputs stays finite."""

from __future__ import annotations

LARGEST = 1e100
"""Differences, quotients and squares of numbers within this bound stay finite."""


def clamped(x: float, low: float, high: float) -> float:
    """Return ``x``, or the bound that it is beyond; infinities are beyond, NaN passes.

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
