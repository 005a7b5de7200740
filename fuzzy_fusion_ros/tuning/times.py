"""A series in seconds, and S2 at the stamps of S1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.series import Reals, Series, Stamps

LONGEST_STEP = 10
"""A step of more than this many usual ones is a gap."""


def seconds(series: Series) -> tuple[Reals, Reals]:
    """Return the times of S1 and of S2 in seconds from the first of S1."""
    origin_ns = series.s1_ns[0]
    return (series.s1_ns - origin_ns) * 1e-9, (series.s2_ns - origin_ns) * 1e-9


def held_s2(series: Series) -> Reals:
    """Return the newest S2 that was known at each S1, NaN before the first, shape (n,)."""
    return np.append(np.nan, series.s2)[series.s2_known]


def in_gaps(stamps_ns: Stamps, wanted_ns: Stamps) -> NDArray[np.bool_]:
    """Return which stamps fall into a gap of a series, where a line across it tells nothing.

    Args:
        stamps_ns: Stamps of the series, rising, shape (m,), nanoseconds.
        wanted_ns: The stamps to look at, shape (n,), nanoseconds.
    """
    steps = np.diff(stamps_ns)
    if steps.size == 0:
        return np.zeros(wanted_ns.shape, np.bool_)
    long = np.concatenate([[False], steps > LONGEST_STEP * np.median(steps), [False]])
    after = np.searchsorted(stamps_ns, wanted_ns, side="left")
    on_sample = stamps_ns[np.minimum(after, steps.size)] == wanted_ns
    inside: NDArray[np.bool_] = long[after] & ~on_sample
    return inside
