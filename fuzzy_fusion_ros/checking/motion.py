# SPDX-License-Identifier: Apache-2.0
"""The motion of a sensor, as it is compared with the other's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.batch.bursts import bursts_of


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
