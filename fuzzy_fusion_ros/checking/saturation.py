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

RUNS, FAR = 3, 0.5
"""The other sensor goes beyond an end and comes back in at least this many runs; or once, by FAR of
its standard deviations, if that ends without a jump, as a sensor that was stuck makes one. Of a
sensor that saturates at one end, one run is enough at the other."""

PARTS = 8
"""Parts of a run over which the other sensor is averaged."""

JUMP, USUAL = 2.0, 0.9
"""A jump is more than JUMP times as large as this share of the steps."""

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
    runs = {
        float(values[k]): _runs(motion, motion.values == values[k], other)
        for k in (0, -1)
        if inside.size >= FEWEST_INSIDE[0]
        and inside.sum() >= FEWEST_INSIDE[1] * motion.values.size
        and counts[k] >= least
    }
    is_sure = any(each.are_sure for each in runs.values())
    ends = [end for end, each in runs.items() if each.are_sure or (is_sure and each.beyond)]
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


class _Runs(NamedTuple):
    """What the other sensor does while one is at an end of its range.

    Attributes:
        beyond: In how many runs it goes on and comes back.
        is_far: Whether it goes far in one that ends without a jump.
    """

    beyond: int
    is_far: bool

    @property
    def are_sure(self) -> bool:
        """Whether the runs hide motion by more than chance."""
        return self.beyond >= RUNS or self.is_far


def _runs(motion: Motion, at_end: Flags, other: Motion) -> _Runs:
    edges = np.flatnonzero(np.diff(at_end, prepend=False, append=False))
    firsts, lasts = edges[::2], edges[1::2] - 1
    steps = np.abs(np.diff(motion.values, append=np.inf))
    jump = JUMP * float(np.quantile(steps[steps > 0.0], USUAL))
    first = np.searchsorted(other.time_s, motion.time_s[firsts])
    stop = np.searchsorted(other.time_s, motion.time_s[lasts], "right")
    long = (lasts - firsts + 1 >= RUN) & (stop - first >= RUN)
    first, stop, lasts = first[long], stop[long], lasts[long]
    returns = np.array([_return(other.values[k:m]) for k, m in zip(first, stop, strict=True)])
    spread = float(np.std(other.values))
    noise = white_noise(other.values) / np.sqrt(np.maximum(1.0, (stop - first) / PARTS))
    least = np.maximum(BEYOND[0] * spread, BEYOND[1] * noise)
    is_far = (returns > np.maximum(least, FAR * spread)) & (steps[lasts] < jump)
    return _Runs(int(np.count_nonzero(returns > least)), bool(is_far.any()))


def _return(values: Reals) -> float:
    """Return how far values go beyond both the first and the last of them and come back.

    Many samples are averaged in parts, so that their noise does not add up to motion.
    """
    means = np.array(
        [float(part.mean()) for part in np.array_split(values, min(PARTS, values.size))]
    )
    return float(np.ptp(means)) - abs(float(means[-1] - means[0]))
