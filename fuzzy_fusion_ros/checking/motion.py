# SPDX-License-Identifier: Apache-2.0
"""The motion of a sensor, as it is compared with the other's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals


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
        """Median time between samples, seconds; infinite for fewer than two."""
        return float(np.median(np.diff(self.time_s))) if self.time_s.size > 1 else np.inf


def motion_of(time_s: Reals, values: Reals) -> Motion:
    """Return motion from samples in any order.

    Args:
        time_s: Times, shape (n,), seconds; of equal ones the first counts.
        values: Shape (n,).
    """
    times, places = np.unique(time_s, return_index=True)
    return Motion(times, values[places])
