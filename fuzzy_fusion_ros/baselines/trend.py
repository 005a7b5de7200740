# SPDX-License-Identifier: Apache-2.0
"""Kalman filter over a value with a slope, robust against outliers.

The value ``x`` is a random walk along the slope ``c``, which is a Gauss-Markov process.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.noise import FINEST, robust_variance
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain


class MotionModel(NamedTuple):
    """How a value with a slope moves.

    Attributes:
        walk: Random walk of the value, standard deviation after a second.
        deviation: Standard deviation of the slope, per second.
        time_constant: With which the slope fades, seconds.
    """

    walk: float
    deviation: float
    time_constant: float


class Trend(NamedTuple):
    """Mean and covariance of a value ``x`` and its slope ``c``, per second."""

    x: float
    c: float
    xx: float
    xc: float
    cc: float


def first_trend(motion: MotionModel, value: float, deviation: float) -> Trend:
    """Return a value with a mean and a standard deviation, its slope unknown about 0."""
    return Trend(
        x=value,
        c=0.0,
        xx=deviation * deviation,
        xc=0.0,
        cc=motion.deviation * motion.deviation,
    )


def propagated(motion: MotionModel, trend: Trend, dt: float) -> Trend:
    """Return the trend after ``dt`` seconds; nothing moves where that is negative."""
    elapsed = max(dt, 0.0)
    lost = lag_gain(elapsed, motion.time_constant)
    t = motion.time_constant * lost
    d = 1.0 - lost
    return Trend(
        x=bounded(trend.x + t * trend.c),
        c=d * trend.c,
        xx=trend.xx + t * (2.0 * trend.xc + t * trend.cc) + motion.walk * motion.walk * elapsed,
        xc=d * (trend.xc + t * trend.cc),
        cc=d * d * trend.cc + (1.0 - d * d) * (motion.deviation * motion.deviation),
    )


def corrected(trend: Trend, value: float, variance: float) -> Trend:
    """Return the trend after a measurement of the value.

    Args:
        trend: Before the measurement.
        value: The measurement.
        variance: Squared scale of its noise.
    """
    away = bounded(value - trend.x)
    noise = robust_variance(max(variance, trend.xx / (FINEST * FINEST)), trend.xx, away)
    total = trend.xx + noise
    gain_x = trend.xx / total
    gain_c = trend.xc / total
    return Trend(
        x=bounded(trend.x + gain_x * away),
        c=bounded(trend.c + gain_c * away),
        xx=max(trend.xx - gain_x * trend.xx, 0.0),
        xc=trend.xc - gain_x * trend.xc,
        cc=max(trend.cc - gain_c * trend.xc, 0.0),
    )
