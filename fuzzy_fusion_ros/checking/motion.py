# SPDX-License-Identifier: Apache-2.0
"""The motion of a sensor, as it is compared with the other's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals

SHORT, LONG = 0.01, 0.1
"""In a burst, stamps are less than SHORT seconds apart (median), and bursts more than LONG: a
receiver stamps what waits in a buffer at once."""

MANY_SHORT = 5.0
"""The time between bursts is more than this many times that between samples in them."""

SHARES = (0.05, 0.45, 0.9, 0.6)
"""Between bursts are at least and at most these shares of the steps, and of the time at least this
share; after this share of them, a burst follows. Two publishers make half of the steps short, a
rate that changes puts the long ones in a row."""

FEWEST_BURSTS = 10
"""Fewer are chance."""


class Bursts(NamedTuple):
    """How samples come.

    Attributes:
        size: How many come at once, on average; 1 for samples that do not come in bursts.
        period: Median time between bursts, or else samples, seconds; infinite for fewer than two.
    """

    size: float
    period: float

    @property
    def interval(self) -> float:
        """Time between samples if bursts were spread evenly, seconds."""
        return self.period / self.size


def bursts_of(time_s: Reals) -> Bursts:
    """Return how samples come.

    Args:
        time_s: Times, rising, shape (n,), seconds.
    """
    steps = np.diff(time_s)
    if steps.size == 0:
        return Bursts(1.0, np.inf)
    usual = float(np.median(steps))
    between = steps > max(MANY_SHORT * usual, SHORT)
    count = int(np.count_nonzero(between))
    if usual > SHORT or count < FEWEST_BURSTS:
        return Bursts(1.0, usual)
    period = float(np.median(steps[between]))
    share = count / steps.size
    follows = float(np.mean(~between[1:][between[:-1]]))
    least, most, least_time, least_follows = SHARES
    is_share = least <= share <= most and steps[between].sum() >= least_time * steps.sum()
    if not is_share or follows < least_follows or period < LONG:
        return Bursts(1.0, usual)
    return Bursts(1.0 / share, period)


@dataclass(frozen=True, eq=False)
class Motion:
    """What a sensor has measured, without wraps and spikes.

    Attributes:
        time_s: Times, rising, shape (n,), seconds.
        values: Shape (n,).
    """

    time_s: Reals
    values: Reals

    @property
    def intervals(self) -> int:
        """How many times between samples it has."""
        return self.time_s.size - 1

    @cached_property
    def interval(self) -> float:
        """Time between samples, or between bursts of them, seconds; infinite for fewer than two."""
        return bursts_of(self.time_s).period

    def kept(self, which: Flags) -> Motion:
        """Return some of the samples, shape (n,) says which."""
        return Motion(self.time_s[which], self.values[which])

    def between(self, start_s: float, end_s: float) -> Motion:
        """Return the motion from one time to another, seconds, both included."""
        return self.kept((self.time_s >= start_s) & (self.time_s <= end_s))


def motion_of(time_s: Reals, values: Reals) -> Motion:
    """Return motion from samples in any order.

    Args:
        time_s: Times, shape (n,), seconds; of equal ones the first counts.
        values: Shape (n,).
    """
    times, places = np.unique(time_s, return_index=True)
    return Motion(times, values[places])


def parted(one: Motion, other: Motion, parts: int) -> list[tuple[Motion, Motion]]:
    """Return two motions in equal parts of the time that both cover."""
    start = float(max(one.time_s[0], other.time_s[0]))
    end = float(min(one.time_s[-1], other.time_s[-1]))
    edges = np.linspace(start, end, parts + 1)
    return [(one.between(*part), other.between(*part)) for part in pairwise(edges)]
