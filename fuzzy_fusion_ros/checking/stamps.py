# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the stamps of one sensor: unusable ones, outliers, clocks that step."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import SensorSamples
from fuzzy_fusion_ros.online.clocks import duration
from fuzzy_fusion_ros.online.guard import Drop

STEP = 1.0
"""Seconds by which stamps and arrivals must part at once for a clock to have stepped. Below it,
the node takes an older stamp for a late one."""

USUAL = 10.0
"""Stamps that advance by up to this many intervals follow lost or delayed messages, no step."""

LASTING = 3
"""Samples in a row that make a timeline; fewer have odd stamps."""

ALTERNATING = 0.1
"""If at least this share of the samples changes the timeline, two clocks stamp one topic."""

FEWEST_BREAKS = 10
"""Fewer changes of the timeline are single odd stamps, in however short a recording."""

MANY = 0.01
"""At this share and above, stamps that are not newer than the last are a fault."""


class ClockStep(NamedTuple):
    """A lasting step of a sensor's clock.

    Attributes:
        at_ns: Arrival of the first sample after it, nanoseconds.
        by: What the stamps have gained on the arrivals, seconds; negative for a step back.
    """

    at_ns: int
    by: float


class Timeline(NamedTuple):
    """The stamps of a sensor, judged.

    Attributes:
        usable: Which samples are on a lasting timeline, shape (n,).
        steps: Where its clock steps.
        findings: What is wrong with single stamps.
    """

    usable: Flags
    steps: tuple[ClockStep, ...]
    findings: tuple[Finding, ...]


def deliveries(samples: SensorSamples) -> Reals:
    """Return how long after its stamp each sample arrived, shape (n,), seconds."""
    return (samples.arrivals_ns - samples.stamps_ns).astype(np.float64) * 1e-9


def judge_stamps(samples: SensorSamples, start_ns: int) -> Timeline:
    """Judge the stamps of a sensor.

    Args:
        samples: Of the sensor.
        start_ns: Arrival time that the seconds in texts count from, nanoseconds.
    """
    possible = (samples.stamps_ns > 0) & ~samples.overflows
    sane = samples.kept(possible)
    findings = [*_unstamped(samples), *_impossible(samples, possible)]
    # Between stamps with impossible nanoseconds, the clock cannot be followed.
    followed = np.diff(np.cumsum(samples.overflows)[possible]) == 0
    numbers, alternates = _timelines(sane, followed)
    usable = possible.copy()
    usable[possible] = numbers >= 0
    lasting = samples.kept(usable)
    if alternates:
        findings.append(_two_clocks(sane, numbers >= 0))
        return Timeline(usable, (), tuple(findings))
    findings += [*_odd(sane, numbers >= 0, start_ns), *_not_newer(lasting)]
    return Timeline(usable, _steps(lasting, numbers[numbers >= 0]), tuple(findings))


def _timelines(samples: SensorSamples, followed: Flags) -> tuple[NDArray[np.int64], bool]:
    """Number the timelines that the samples are on, -1 for none; say whether two alternate.

    Args:
        samples: Those with possible stamps, shape (n,).
        followed: Whether the clock can be followed from each to the next, shape (n - 1,).
    """
    late = deliveries(samples)
    if late.size < LASTING:
        return np.zeros(late.size, np.int64), False
    stamp_steps = np.diff(samples.stamps_ns) * 1e-9
    interval = float(np.median(np.abs(stamp_steps)))
    regular = (stamp_steps > 0.0) & (stamp_steps <= USUAL * interval)
    breaks = (np.abs(np.diff(late)) > STEP) & ~regular & followed
    near = _near_median(late)
    alternates = np.count_nonzero(breaks) >= max(ALTERNATING * late.size, FEWEST_BREAKS)
    if alternates and not near.all():
        return np.where(near, 0, -1), True
    starts = np.append(0, np.flatnonzero(breaks) + 1)
    numbers = np.full(late.size, -1, np.int64)
    number, level = -1, np.inf
    for start, stop in zip(starts, np.append(starts[1:], late.size), strict=True):
        if stop - start < LASTING:
            continue
        if abs(late[start] - level) > STEP:
            number += 1
        numbers[start:stop] = number
        level = late[stop - 1]
    return numbers, False


def _near_median(late: Reals) -> Flags:
    """Return which samples are on the clock of the majority."""
    typical = np.sort(late)[late.size // 2]
    near: Flags = np.abs(late - typical) <= STEP
    return near


def _steps(samples: SensorSamples, numbers: NDArray[np.int64]) -> tuple[ClockStep, ...]:
    late = deliveries(samples)
    firsts = np.flatnonzero(np.diff(numbers)) + 1
    return tuple(
        [ClockStep(int(samples.arrivals_ns[k]), float(late[k - 1] - late[k])) for k in firsts]
    )


def _unstamped(samples: SensorSamples) -> list[Finding]:
    if samples.is_stamped:
        return []
    text = (
        f"messages of {samples.name} have no timestamp; using the time of arrival, so transport "
        "delay will look like motion"
    )
    return [Finding(Level.INFO, "no timestamp", text, {})]


def _impossible(samples: SensorSamples, possible: Flags) -> list[Finding]:
    n = samples.stamps_ns.size
    level = Level.WARNING if possible.any() else Level.ERROR
    kinds = {
        Drop.BAD_NANOSECONDS: samples.overflows,
        Drop.ZERO_STAMP: (samples.stamps_ns == 0) & ~samples.overflows,
        Drop.NEGATIVE_STAMP: (samples.stamps_ns < 0) & ~samples.overflows,
    }
    return [
        Finding(level, "stamps", _dropped(int(np.count_nonzero(which)), n, samples.name, drop), {})
        for drop, which in kinds.items()
        if which.any()
    ]


def _dropped(count: int, of: int, name: str, why: Drop) -> str:
    return f"{count} of {of} samples of {name} are dropped: {why.value}"


def _two_clocks(samples: SensorSamples, majority: Flags) -> Finding:
    late = deliveries(samples)
    apart = float(np.median(late[~majority]) - np.median(late[majority]))
    share = 1.0 - float(np.mean(majority))
    text = f"stamps of {samples.name} alternate between two clocks {duration(abs(apart))} apart"
    remedy = "keep only one publisher on its topic"
    return Finding(Level.ERROR, "two clocks", text, {"share of the second": share}, remedy)


def _odd(samples: SensorSamples, lasting: Flags, start_ns: int) -> list[Finding]:
    odd = np.flatnonzero(~lasting)
    if odd.size == 0:
        return []
    late = deliveries(samples)
    usual = float(np.median(late[lasting])) if lasting.any() else 0.0
    worst = odd[np.argmax(np.abs(late[odd] - usual))]
    by = float(late[worst] - usual)
    at_s = (int(samples.arrivals_ns[worst]) - start_ns) * 1e-9
    text = (
        f"{odd.size} of {late.size} samples of {samples.name} are dropped: their stamps are off "
        f"by up to {duration(abs(by))} ({'behind' if by > 0.0 else 'ahead'}, at {at_s:.1f} s)"
    )
    return [Finding(Level.WARNING, "stamps", text, {})]


def _not_newer(samples: SensorSamples) -> list[Finding]:
    steps = np.diff(samples.stamps_ns)
    late = np.diff(deliveries(samples))
    count = int(np.count_nonzero((steps <= 0) & (late < STEP)))
    if count == 0:
        return []
    n = samples.stamps_ns.size
    level = Level.WARNING if count >= MANY * n else Level.INFO
    return [Finding(level, "stamps", _dropped(count, n, samples.name, Drop.NOT_NEWER), {})]
