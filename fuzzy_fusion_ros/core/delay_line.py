# SPDX-License-Identifier: Apache-2.0
"""A short memory of a signal, to read it as it was a moment ago."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.numerics import seconds_between

CAPACITY = 32
"""Points kept."""

REACH = 24
"""Points that span the delay; the rest is for S2 samples that come late."""


class DelayLine(NamedTuple):
    """Points of a signal, oldest first.

    Attributes:
        filled: How many points are there.
        stamps_ns: Their stamps, nanoseconds, shape (CAPACITY,), filled from the end.
        values: Their values, shape (CAPACITY,).
    """

    filled: int
    stamps_ns: NDArray[np.int64]
    values: NDArray[np.float64]


def empty_line() -> DelayLine:
    """Return a line without points."""
    return DelayLine(filled=0, stamps_ns=np.zeros(CAPACITY, np.int64), values=np.zeros(CAPACITY))


def extended(line: DelayLine, stamp_ns: int, value: float, delay: float) -> DelayLine:
    """Return a line that remembers a sample, if it is far enough from the last point.

    Points are ``delay / REACH`` seconds apart at least, so a line reaches back over the delay
    at any sample rate.
    """
    if line.filled > 0 and seconds_between(int(line.stamps_ns[-1]), stamp_ns) < delay / REACH:
        return line
    stamps_ns = np.empty_like(line.stamps_ns)
    values = np.empty_like(line.values)
    stamps_ns[:-1] = line.stamps_ns[1:]
    values[:-1] = line.values[1:]
    stamps_ns[-1] = stamp_ns
    values[-1] = value
    return DelayLine(filled=min(line.filled + 1, CAPACITY), stamps_ns=stamps_ns, values=values)


def shifted(line: DelayLine, step: float) -> DelayLine:
    """Return a line with ``step`` added to every point."""
    return DelayLine(filled=line.filled, stamps_ns=line.stamps_ns, values=line.values + step)


def delayed(line: DelayLine, newest_ns: int, newest: float, stamp_ns: int, delay: float) -> float:
    """Return the signal ``delay`` seconds before ``stamp_ns``.

    Between points it is a straight line; before the first and after the newest it is theirs.

    Args:
        line: Points of the signal, none newer than ``newest_ns``.
        newest_ns: Stamp of the newest sample.
        newest: The newest sample.
        stamp_ns: The stamp to look back from.
        delay: How far to look back, seconds.
    """
    later_ns = newest_ns
    later = newest
    if seconds_between(later_ns, stamp_ns) >= delay:
        return later
    for k in range(CAPACITY - 1, CAPACITY - 1 - line.filled, -1):
        earlier_ns = int(line.stamps_ns[k])
        earlier = float(line.values[k])
        beyond = seconds_between(earlier_ns, stamp_ns) - delay
        if beyond >= 0.0:
            span = seconds_between(earlier_ns, later_ns)
            share = beyond / span if span > 0.0 else 0.0
            return earlier + share * (later - earlier)
        later_ns = earlier_ns
        later = earlier
    return later
