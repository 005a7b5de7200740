# SPDX-License-Identifier: Apache-2.0
"""Series at the stamps of other series."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps, unwrapped
from fuzzy_fusion_ros.offline.tracks import Track

LONGEST_STEP = 10
"""A step of more than this many median ones is a gap."""


def interpolated(track: Track, stamps_ns: Stamps, period: float = 0.0) -> Reals:
    """Return a track between its samples, on straight lines.

    Args:
        track: Samples in rising order of stamps.
        stamps_ns: Where it is wanted, shape (n,), nanoseconds.
        period: A full turn of what wraps; lines then go the short way, and the result is
            continuous. 0 if it does not wrap.

    Returns:
        Shape (n,); NaN before the first and after the last sample, and in gaps: nothing is
        extrapolated, and nothing made up.
    """
    found = np.full(stamps_ns.shape, np.nan)
    if track.stamps_ns.size == 0:
        return found
    inside = (stamps_ns >= track.stamps_ns[0]) & (stamps_ns <= track.stamps_ns[-1])
    wanted = stamps_ns[inside]
    after = np.searchsorted(track.stamps_ns, wanted, side="left")
    before = np.where(track.stamps_ns[after] == wanted, after, after - 1)
    gap = track.stamps_ns[after] - track.stamps_ns[before]
    share = (wanted - track.stamps_ns[before]) / np.maximum(gap, 1)
    values = unwrapped(track.values, period)
    found[inside] = (1.0 - share) * values[before] + share * values[after]
    found[in_gaps(track.stamps_ns, stamps_ns)] = np.nan
    return found


def in_gaps(stamps_ns: Stamps, wanted_ns: Stamps) -> Flags:
    """Return which stamps fall into a gap of a series, where interpolation is meaningless.

    Args:
        stamps_ns: Stamps of the series, rising, shape (m,), nanoseconds.
        wanted_ns: The stamps in question, shape (n,), nanoseconds.
    """
    steps = np.diff(stamps_ns)
    if steps.size == 0:
        return np.zeros(wanted_ns.shape, np.bool_)
    long = np.concatenate([[False], steps > LONGEST_STEP * np.median(steps), [False]])
    after = np.searchsorted(stamps_ns, wanted_ns, side="left")
    on_sample = stamps_ns[np.minimum(after, steps.size)] == wanted_ns
    inside: Flags = long[after] & ~on_sample
    return inside


def gap_time(stamps_ns: Stamps, wanted_ns: Stamps) -> Reals:
    """Return how long the gaps of a series before some stamps are, beyond a usual step.

    Args:
        stamps_ns: Stamps of the series, rising, shape (m,), nanoseconds.
        wanted_ns: The stamps in question, shape (n,), nanoseconds.

    Returns:
        Shape (n,), seconds.
    """
    steps = np.diff(stamps_ns)
    usual = np.median(steps) if steps.size else 0.0
    long = steps > LONGEST_STEP * usual
    passed = np.searchsorted(stamps_ns[1:][long], wanted_ns, side="right")
    found: Reals = np.append(0.0, np.cumsum(steps[long] - usual))[passed] * 1e-9
    return found


def held(stamps_ns: Stamps, values: Reals, wanted_ns: Stamps) -> Reals:
    """Return a series held from sample to sample, NaN before the first.

    Args:
        stamps_ns: Its stamps, rising, shape (m,), nanoseconds.
        values: Its values, shape (m,).
        wanted_ns: Where it is wanted, shape (n,), nanoseconds.
    """
    newest = np.searchsorted(stamps_ns, wanted_ns, side="right") - 1
    return np.where(newest >= 0, np.append(values, np.nan)[newest], np.nan)
