# SPDX-License-Identifier: Apache-2.0
"""Where the direction of a vector means nothing, as the course of a vehicle at standstill."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, nearest, root_mean_square

SHORT, LONG = 0.1, 0.95
"""A vector is short below this share of the length that this share of all stays below."""

ROUGH = 1.0
"""Steps are random if changes from one to the next have this many times their mean square: noise
has 2 or 3 times, a turn far less."""

FEWEST = 10
"""With fewer samples in a row of either, short and long vectors are not told apart."""


def meaningless(angles: Reals, lengths: Reals, period: float) -> Flags:
    """Return where a direction means nothing: where its vector is short, if it scatters there.

    A robot that turns on the spot has a heading although it has no speed: that does not scatter.

    Args:
        angles: Directions, shape (n,), NaN where there is none.
        lengths: Of the vectors, shape (n,), NaN where unknown.
        period: A turn, unit of the angles.
    """
    nowhere = np.zeros(angles.size, np.bool_)
    known = np.isfinite(angles) & np.isfinite(lengths)
    if not known.any():
        return nowhere
    short = known & (lengths < SHORT * np.quantile(lengths[known], LONG))
    long = known & ~short
    steps = nearest(np.diff(angles), 0.0, period)
    at_rest, moving = short[1:] & short[:-1], long[1:] & long[:-1]
    in_a_row = at_rest[1:] & at_rest[:-1]
    if min(np.count_nonzero(in_a_row), np.count_nonzero(moving)) < FEWEST:
        return nowhere
    scatter, usual = (root_mean_square(steps[which]) for which in (at_rest, moving))
    rough = root_mean_square(np.diff(steps)[in_a_row]) ** 2 > ROUGH * scatter**2
    return short if rough and scatter > usual else nowhere
