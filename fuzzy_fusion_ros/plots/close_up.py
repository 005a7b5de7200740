# SPDX-License-Identifier: Apache-2.0
"""Which stretch of a recording to show close up."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals

CLOSE_UP = 0.05
"""Length of the close-up as a share of the whole, at least."""

STEPS = 15.0
"""Length of the close-up in samples of S2, at least."""


def close_up(time_s: Reals, signal: Reals, s2: Reals) -> Flags:
    """Mark the stretch of a recording in which a signal varies most, shape (n,).

    Args:
        time_s: Times, rising, shape (n,), seconds.
        signal: The truth, or what is closest to it, shape (n,); NaN where unknown.
        s2: S2, held between its samples, shape (n,); the stretch holds several of them.
    """
    span = float(time_s[-1] - time_s[0])
    interval = span / max(int(np.count_nonzero(np.diff(s2))), 1)
    length = min(span, max(CLOSE_UP * span, STEPS * interval))
    whole = time_s <= time_s[-1] - length + 1e-9
    starts = np.arange(time_s.size)[whole]
    ends = np.searchsorted(time_s, time_s[whole] + length, side="right")
    about_mean = np.nan_to_num(signal - np.nanmean(signal))
    sums = np.append(0.0, np.cumsum(about_mean))
    squares = np.append(0.0, np.cumsum(np.square(about_mean)))
    counts = ends - starts
    means = (sums[ends] - sums[starts]) / counts
    best = int(np.argmax((squares[ends] - squares[starts]) / counts - np.square(means)))
    near = np.zeros(time_s.size, bool)
    near[starts[best] : ends[best]] = True
    return near
