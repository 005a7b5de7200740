# SPDX-License-Identifier: Apache-2.0
"""Whether a sensor stops at the ends of its range while the other moves on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, white_noise
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.motion import Motion

RUN = 3
"""Equal samples in a row that may be an end of the range; noise can dip below it in between."""

RUNS = 3
"""The other sensor goes beyond an end and comes back in at least this many runs: once is chance."""

SHARE = 0.02
"""Share of the samples that are at an end, at least."""

FREQUENT = 5.0
"""An end has this many times the samples of any value inside the range. The top level of a sine in
steps has at most 2.4 times those of the next."""

FEWEST_INSIDE = (20, 0.2)
"""There are this many values inside the range, with this share of the samples: a switch has none,
a sensor that rests at an end has few."""

BEYOND = (0.1, 6.0)
"""The other sensor goes on by this share of its standard deviation, and by this many times its
noise."""


class Saturation(NamedTuple):
    """Where a sensor saturates.

    Attributes:
        clipped: Which samples are there, shape (n,).
        findings: That it saturates, unless it does not.
    """

    clipped: Flags
    findings: tuple[Finding, ...]


def saturation_of(name: str, motion: Motion, other_name: str, other: Motion) -> Saturation:
    """Judge whether a sensor saturates.

    A sensor that rests at an end of its range, such as a speed at standstill, does not: the other
    sensor then comes to rest, too. Only if the other goes on in one direction and comes back within
    a run of equal samples does the run hide motion.

    Args:
        name: The sensor.
        motion: Its motion.
        other_name: The other sensor.
        other: Its motion.
    """
    values, counts = np.unique(motion.values, return_counts=True)
    inside = counts[1:-1]
    usual = int(inside.max(initial=0))
    least = max(FREQUENT * usual, SHARE * motion.values.size)
    ends = [
        float(values[k])
        for k in (0, -1)
        if inside.size >= FEWEST_INSIDE[0]
        and inside.sum() >= FEWEST_INSIDE[1] * motion.values.size
        and counts[k] >= least
        and _goes_on(motion, motion.values == values[k], other)
    ]
    clipped = np.isin(motion.values, ends)
    if not ends:
        return Saturation(clipped, ())
    where = " and ".join(f"{end:.4g}" for end in ends)
    text = (
        f"{name} saturates at {where}: {100.0 * float(np.mean(clipped)):.2g} % of its samples are "
        f"there while {other_name} moves on; they are left out of the comparison"
    )
    remedy = "set a wider range in its driver, or choose a part without them by --start and --end"
    return Saturation(clipped, (Finding(Level.WARNING, "saturated", text, {}, remedy),))


def _goes_on(motion: Motion, at_end: Flags, other: Motion) -> bool:
    """Return whether the other sensor moves and comes back in several runs at an end."""
    edges = np.flatnonzero(np.diff(at_end, prepend=False, append=False))
    firsts, lasts = edges[::2], edges[1::2] - 1
    long = lasts - firsts + 1 >= RUN
    starts, ends = motion.time_s[firsts[long]], motion.time_s[lasts[long]]
    first = np.searchsorted(other.time_s, starts)
    stop = np.searchsorted(other.time_s, ends, "right")
    least = max(BEYOND[0] * float(np.std(other.values)), BEYOND[1] * white_noise(other.values))
    returns = [_return(other.values[k:m]) for k, m in zip(first, stop, strict=True) if m - k >= RUN]
    return sum(each > least for each in returns) >= RUNS


def _return(values: Reals) -> float:
    """Return how far values go beyond both the first and the last of them and come back."""
    return float(np.ptp(values)) - abs(float(values[-1] - values[0]))
