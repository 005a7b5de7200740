# SPDX-License-Identifier: Apache-2.0
"""Series at the stamps of other series."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, Stamps, unwrapped
from fuzzy_fusion_ros.offline.tracks import Track


def interpolated(track: Track, stamps_ns: Stamps, period: float = 0.0) -> Reals:
    """Return a track between its samples, on straight lines.

    Args:
        track: Samples in rising order of stamps.
        stamps_ns: Where it is wanted, shape (n,), nanoseconds.
        period: A full turn of what wraps; lines then go the short way, and the result is
            continuous. 0 if it does not wrap.

    Returns:
        Shape (n,); NaN before the first and after the last sample: nothing is extrapolated.
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
