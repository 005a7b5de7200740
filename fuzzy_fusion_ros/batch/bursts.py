# SPDX-License-Identifier: Apache-2.0
"""Whether samples come one by one or in bursts, and how often."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals

MANY_SHORT = 8.0
"""The time between bursts is at least this many times that between samples in them (medians)."""

SHARES = (0.05, 0.6, 0.5, 0.6)
"""Between bursts are at least and at most these shares of the steps, and of the time at least this
share; after this share of them, a burst follows. Pairs make half of the steps short, a rate that
changes puts the long ones in a row. Where more samples come at once, these show the motion."""

FEWEST_BURSTS = 10
"""Fewer are chance."""


class Bursts(NamedTuple):
    """How samples come.

    Attributes:
        size: How many come at once, on average; 1 for samples that do not come in bursts.
        period: Median time between bursts, or else samples, seconds; infinite for fewer than two.
        between: Which steps from sample to sample lead to the next burst, shape (n - 1,): all,
            where there are no bursts.
        within: Median time between the samples of a burst, seconds; 0 where there are no bursts.
    """

    size: float
    period: float
    between: Flags
    within: float

    @property
    def interval(self) -> float:
        """Time between samples if bursts were spread evenly, seconds."""
        return (self.period + (self.size - 1.0) * self.within) / self.size


def bursts_of(time_s: Reals) -> Bursts:
    """Return how samples come.

    Args:
        time_s: Times, rising, shape (n,), seconds.
    """
    steps = np.diff(time_s)
    usual = float(np.median(steps)) if steps.size else np.inf
    one_by_one = Bursts(1.0, usual, np.ones(steps.size, np.bool_), 0.0)
    if steps.size <= FEWEST_BURSTS:
        return one_by_one
    short, long = np.quantile(steps, [0.25, 1.0 - 0.5 * SHARES[0]])
    between = steps > np.sqrt(short * long)
    count = int(np.count_nonzero(between))
    share = count / steps.size
    least, most, least_time, least_follows = SHARES
    if count < FEWEST_BURSTS or not least <= share <= most:
        return one_by_one
    within = float(np.median(steps[~between]))
    period = float(np.median(steps[between]))
    is_mostly = steps[between].sum() >= least_time * steps.sum()
    follows = float(np.mean(~between[1:][between[:-1]]))
    if not is_mostly or period < MANY_SHORT * within or follows < least_follows:
        return one_by_one
    return Bursts(1.0 / share, period, between, within)
