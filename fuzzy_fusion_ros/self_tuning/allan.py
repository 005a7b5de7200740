# SPDX-License-Identifier: Apache-2.0
"""Allan's statistic of a running series: how much means over longer and longer times differ.

Differences of successive means over 1, 2, 4, ... samples. White noise averages out, so its
differences fall from octave to octave; whatever moves makes them rise. Where they are least is
how long it pays to average.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.numerics import clamped

Reals = NDArray[np.float64]

LEAST_MEMORY = 8
"""Differences of an octave that are remembered at least."""

FEWEST = 4
"""Fewer differences of an octave say nothing."""

SIGMA_OVER_USUAL = 1.0 / (0.8221789586623885**2 * math.sqrt(2.0))
"""Standard deviation of normal numbers, over the size of differences of two of them."""


class Octaves(NamedTuple):
    """The statistic of k series at a time.

    Attributes:
        counts: Differences seen, of each octave.
        pending: The mean that waits for its partner, of each octave, shape (k,); ``None`` without.
        roots: Running mean of the root of each difference, of each octave, shape (k,): a few
            large ones count little.
        squares: The same of their squares: a few large ones count much.
    """

    counts: tuple[int, ...]
    pending: tuple[Any, ...]
    roots: tuple[Any, ...]
    squares: tuple[Any, ...]


def no_octaves(octaves: int, series: int) -> Octaves:
    """Return the state before any sample.

    Args:
        octaves: Number of octaves.
        series: Number of series.
    """
    zeros = (np.zeros(series),) * octaves
    return Octaves((0,) * octaves, (None,) * octaves, zeros, zeros)


def counted(kept: Octaves, values: Reals, is_gap: bool, memory: int) -> Octaves:
    """Take the next sample of each series.

    Args:
        kept: The state so far.
        values: The samples, shape (k,), finite.
        is_gap: Whether samples are missing before it: means do not reach over a gap.
        memory: Differences of single samples that are remembered; an octave up half as many, and
            so on.
    """
    counts, roots, squares = list(kept.counts), list(kept.roots), list(kept.squares)
    pending = [None] * len(counts) if is_gap else list(kept.pending)
    for octave, partner in enumerate(pending):
        if partner is None:
            pending[octave] = values
            break
        pending[octave] = None
        counts[octave] = min(counts[octave] + 1, max(memory >> octave, LEAST_MEMORY))
        apart = np.abs(values - partner)
        roots[octave] = roots[octave] + (np.sqrt(apart) - roots[octave]) / counts[octave]
        squares[octave] = squares[octave] + (apart * apart - squares[octave]) / counts[octave]
        values = 0.5 * (values + partner)
    return Octaves(tuple(counts), tuple(pending), tuple(roots), tuple(squares))


def usual(kept: Octaves) -> Reals:
    """Return the usual difference, shape (octaves, k), of octaves that say something."""
    return np.square(_known(kept, kept.roots))


def root_mean_square(kept: Octaves) -> Reals:
    """Return the root mean square of the differences, shape (octaves, k), in the same way."""
    return np.sqrt(_known(kept, kept.squares))


def _known(kept: Octaves, means: tuple[Any, ...]) -> Reals:
    known = [m for n, m in zip(kept.counts, means, strict=True) if n >= FEWEST]
    return np.array(known).reshape(-1, means[0].size)


def averaging_time(size: Reals, interval: float) -> float:
    """Return the time constant of the best average, seconds; 0 if single samples are best.

    White noise of density ``N`` and a random walk of ``q`` leave ``N / t + q^2 t / 3`` in means
    over ``t``, least at ``t = sqrt(3 N) / q``; the filter for both has ``sqrt(N) / q``.

    Args:
        size: Of the differences of one series, shape (octaves,).
        interval: Time between samples, seconds.
    """
    best = int(np.argmin(size)) if size.size else 0
    if best == 0:
        return 0.0
    with np.errstate(divide="ignore"):  # no difference at all is the least there is
        curve = np.log(size)
    return float(interval * 2.0 ** (best + vertex(curve, best)) / math.sqrt(3.0))


def vertex(curve: Reals, lowest: int) -> float:
    """Return where the parabola through three points is least, from the middle one, -0.5 to 0.5.

    Args:
        curve: Points at even distances.
        lowest: Index of the lowest; at an end it is the answer itself.
    """
    if lowest in {0, curve.size - 1}:
        return 0.0
    left, middle, right = curve[lowest - 1 : lowest + 2]
    bend = left - 2.0 * middle + right
    place = float(0.5 * (left - right) / bend) if bend > 0.0 else 0.0
    return clamped(place, -0.5, 0.5)
