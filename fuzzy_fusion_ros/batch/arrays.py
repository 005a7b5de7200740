# SPDX-License-Identifier: Apache-2.0
"""Types of arrays over a recording, and the statistics of them that several rooms need."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.self_tuning.spikes import SIGMA_OVER_MEDIAN

Reals = NDArray[np.float64]
Stamps = NDArray[np.int64]
"""Nanoseconds."""
Flags = NDArray[np.bool_]

CONSTANT = 1e-9
"""A series that varies by less is constant but for rounding."""


def seconds_since(origin_ns: int, stamps_ns: Stamps) -> Reals:
    """Return stamps as seconds from an origin; differences are exact before they are scaled."""
    return (stamps_ns - origin_ns).astype(np.float64) * 1e-9


def nearest(values: Reals, references: Reals | float, period: float) -> Reals:
    """Return values whole turns away that are nearest to references, as :mod:`.core.periodic` does.

    Args:
        values: Finite or NaN, shape (n,).
        references: Shape (n,), or one for all.
        period: A turn; 0 leaves the values as they are.
    """
    if period == 0.0:
        return values
    turned: Reals = values - period * np.ceil((values - references) / period - 0.5)
    return turned


def unwrapped(values: Reals, period: float) -> Reals:
    """Return a series in which each value is the one nearest to the one before.

    Args:
        values: Finite, shape (n,).
        period: A turn; 0 leaves the values as they are.
    """
    if period == 0.0 or values.size == 0:
        return values
    steps = np.diff(values)
    ahead = np.cumsum(np.ceil(steps / period - 0.5))
    return values - period * np.append(0.0, ahead)


def root_mean_square(values: Reals) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def integral_absolute_error(time_s: Reals, error: Reals) -> float:
    """Eq. (14): the time integral of the error's magnitude; each sample holds until the next.

    Args:
        time_s: Times, rising, shape (n,), seconds.
        error: Shape (n,).
    """
    return float(np.sum(np.abs(error) * _durations(time_s)))


def integral_time_absolute_error(time_s: Reals, error: Reals) -> float:
    """Eq. (15): that integral, weighted by the time since the first sample.

    Args:
        time_s: Times, rising, shape (n,), seconds.
        error: Shape (n,).
    """
    elapsed = time_s - time_s[0]
    return float(np.sum(elapsed * np.abs(error) * _durations(time_s)))


def white_noise(values: Reals) -> float:
    """Return the standard deviation of the white noise in a series, from second differences.

    Args:
        values: At roughly even intervals, shape (n,), n at least 3.
    """
    return float(np.median(np.abs(np.diff(values, n=2))) * SIGMA_OVER_MEDIAN / np.sqrt(6.0))


def _durations(time_s: Reals) -> Reals:
    """Return how long each sample holds; the last one as long as the one before it."""
    steps = np.diff(time_s)
    return np.append(steps, steps[-1:]) if steps.size else np.zeros(1)
