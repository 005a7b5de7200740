# SPDX-License-Identifier: Apache-2.0
"""Excerpts of a recording that is too long to be fitted to as a whole."""

from __future__ import annotations

import math

import numpy as np

from fuzzy_fusion_ros.offline.recording import Recording
from fuzzy_fusion_ros.offline.tracks import Track

MOST = 1_000_000
"""A recording of no more samples of S1 is taken as a whole."""

EXCERPTS = 8
"""Most excerpts of a longer one, evenly spread, of ``MOST`` samples together."""

FEWEST_S2 = 100
"""Samples of S2 that an excerpt has on average, at least; of a slow S2, excerpts are fewer."""


def excerpts(recording: Recording) -> list[Recording]:
    """Return a recording as a whole, or of a long one excerpts that do not keep it in memory.

    Args:
        recording: The recording. Of one with a truth, excerpts are from the span of the truth, or
            are that span; they keep the truth and the series alone.
    """
    series, truth_ns = recording.series, recording.truth.stamps_ns
    first, last = 0, series.s1.size
    if truth_ns.size:
        first, last = np.searchsorted(series.s1_ns, [truth_ns[0], truth_ns[-1]]).tolist()
    per_s2 = series.s1.size / max(series.s2.size, 1)
    if series.s1.size <= MOST or last == first:
        return [recording]
    size = min(max(MOST // EXCERPTS, math.ceil(FEWEST_S2 * per_s2)), MOST)
    number = MOST // size
    if last - first <= number * size:
        number, size = 1, last - first
    begins = np.linspace(first, last - size, number).astype(int).tolist()
    parts = f"{number} excerpts of {size:,}, evenly spread" if number > 1 else f"{size:,} of them"
    note = (
        f"{series.s1.size:,} samples of S1: the fit is to {parts}; --start and --end choose one "
        "span"
    )
    found = [_excerpt(recording, each, each + size) for each in begins]
    return [found[0]._replace(notes=(*recording.notes, note)), *found[1:]]


def _excerpt(recording: Recording, begin: int, end: int) -> Recording:
    series, truth = recording.series.part(begin, end), recording.truth
    near = np.searchsorted(truth.stamps_ns, series.s1_ns[[0, -1]])
    return recording._replace(
        s1=_part(recording.s1, slice(0)),
        s2=_part(recording.s2, slice(0)),
        estimate=_part(recording.estimate, slice(0)),
        truth=_part(truth, slice(max(int(near[0]) - 1, 0), int(near[1]) + 1)),
        series=series,
        notes=(),
    )


def _part(track: Track, part: slice) -> Track:
    return Track._make(each[part].copy() for each in track)
