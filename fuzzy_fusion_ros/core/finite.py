"""A bound that keeps arithmetic on out-of-range inputs finite."""

from __future__ import annotations

LARGEST = 1e100
"""Differences, quotients and squares of numbers within this bound stay finite."""


def bounded(x: float) -> float:
    """Return ``x`` within ``LARGEST``, infinities included."""
    return min(max(x, -LARGEST), LARGEST)
