# SPDX-License-Identifier: Apache-2.0
"""How long a sensor may be silent: its interval, tracked, and the resulting timeout."""

from __future__ import annotations

from fuzzy_fusion_ros.core.numerics import clamped

S1_TIMEOUT = 1.0
"""The shortest automatic timeout of S1, seconds."""

S2_TIMEOUT = 5.0
"""The shortest automatic timeout of S2, seconds."""

INTERVALS = 5.0
"""Intervals that an automatic timeout lasts at least."""

_SHARE = 0.1
_LONGEST = 3.0


def followed(interval: float, dt: float) -> float:
    """Return the interval of a sensor after another sample, seconds.

    A running mean in which a gap counts as at most three intervals.

    Args:
        interval: The interval so far, 0 before the second sample.
        dt: Time since the last sample, seconds.
    """
    if interval <= 0.0:
        return dt
    return interval + _SHARE * (clamped(dt, 0.0, _LONGEST * interval) - interval)


def timeout_for(configured: float, shortest: float, interval: float) -> float:
    """Return after how long without a sample a sensor counts as lost, seconds.

    Args:
        configured: The parameter; 0 is automatic.
        shortest: The shortest automatic timeout, seconds.
        interval: The interval of the sensor as :func:`followed`, seconds.
    """
    if configured > 0.0:
        return configured
    return max(shortest, INTERVALS * interval)
