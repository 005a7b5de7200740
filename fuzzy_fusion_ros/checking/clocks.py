# SPDX-License-Identifier: Apache-2.0
"""Whether the clocks that stamp two sensors agree: stamps against arrivals, and against motion."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, seconds_since
from fuzzy_fusion_ros.batch.bursts import bursts_of
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import SensorSamples
from fuzzy_fusion_ros.checking.stamps import STEP, ClockStep, deliveries
from fuzzy_fusion_ros.online.clocks import SYNCHRONIZE, apart, duration

NEGLIGIBLE = 0.1
"""Stamps that differ by at most this many seconds, compared at equal arrival, do not matter."""

LONGEST_DELIVERY = 60.0
"""No message takes longer than this many seconds."""

SOONEST_DELIVERY = -0.05
"""No message arrives before it is stamped, except for this much jitter between clocks, seconds."""

USUAL_DELIVERY = 1.0
"""Late delivery costs 1 per this many seconds, in the evidence of :mod:`.relation`."""

CLOCKS_APART = 3.0
"""Cost of a clock offset there: one set-up in twenty."""

WITHOUT_MOTION = 2.0
"""Where motion does not decide, stamps that differ by more than this many seconds mean a clock."""

LOST_AFTER = 3.0
"""A late sensor counts as lost only after this many more intervals."""

TOGETHER = 2.0
"""Clocks of both sensors that step within this many seconds are one clock, or a looped bag."""

Compare = Callable[[Reals, Reals], float | None]
"""Compares motion, given times of S1 and S2 in seconds; returns what the most credible hypothesis
costs, ``None`` if motion shows none."""


class Clocks(NamedTuple):
    """The clocks of two sensors, judged.

    Attributes:
        behind: How far S2's stamps are behind S1's when both arrive, median, seconds; negative if
            they are ahead, NaN if a clock steps.
        s1_s: Times of S1 to compare motion by, seconds from the start, shape (n,).
        s2_s: Those of S2, shape (m,).
        findings: What is wrong.
    """

    behind: float
    s1_s: Reals
    s2_s: Reals
    findings: tuple[Finding, ...]


class Stamped(NamedTuple):
    """A sensor and the steps of its clock.

    Attributes:
        samples: Those with usable stamps, at least one.
        steps: Where the clock steps.
    """

    samples: SensorSamples
    steps: tuple[ClockStep, ...]

    @property
    def delivery(self) -> float:
        """Median time from stamp to arrival, seconds."""
        return float(np.median(deliveries(self.samples)))

    def times(self, start_ns: int, delivery: float) -> Reals:
        """Return when its samples were measured, seconds from a time of arrival.

        Args:
            start_ns: The time of arrival, nanoseconds.
            delivery: Between a stamp of its clock and the arrival of a sample measured then.
        """
        return seconds_since(start_ns - round(delivery * 1e9), self.samples.stamps_ns)

    def between(self, begin_ns: int, end_ns: int) -> Stamped:
        """Return it without what arrived before one time, or from another on."""
        arrivals_ns = self.samples.arrivals_ns
        kept = self.samples.kept((arrivals_ns >= begin_ns) & (arrivals_ns < end_ns))
        return Stamped(kept, ())


def judge_clocks(s1: Stamped, s2: Stamped, start_ns: int, compare: Compare) -> Clocks:
    """Judge the clocks that stamp two sensors.

    Args:
        s1: S1.
        s2: S2.
        start_ns: Arrival time that the seconds in texts count from, nanoseconds.
        compare: Called where only motion can decide.
    """
    if s1.steps or s2.steps:
        s1_s, s2_s = (seconds_since(start_ns, each.samples.arrivals_ns) for each in (s1, s2))
        return Clocks(np.nan, s1_s, s2_s, tuple(_steps(s1, s2, start_ns)))
    behind = _behind(s1.samples, s2.samples)
    by_stamps = s1.times(start_ns, s1.delivery), s2.times(start_ns, s1.delivery)
    if abs(behind) <= NEGLIGIBLE:
        return Clocks(behind, *by_stamps, ())
    together = by_stamps[0], s2.times(start_ns, s1.delivery + behind)
    if _is_late(behind, s1, s2, lambda: compare(*by_stamps), lambda: compare(*together)):
        return Clocks(behind, *by_stamps, (_late(behind, s1, s2),))
    return Clocks(behind, *together, (_apart(behind),))


def _behind(s1: SensorSamples, s2: SensorSamples) -> float:
    """Return how far S2's stamps are behind S1's, the median over the arrivals of S2, seconds."""
    of_s1 = np.interp(
        seconds_since(int(s1.arrivals_ns[0]), s2.arrivals_ns),
        seconds_since(int(s1.arrivals_ns[0]), s1.arrivals_ns),
        deliveries(s1),
    )
    return float(np.median(deliveries(s2) - of_s1))


def _is_late(
    behind: float,
    s1: Stamped,
    s2: Stamped,
    by_stamps: Callable[[], float | None],
    together: Callable[[], float | None],
) -> bool:
    """Return whether stamps differ by late delivery rather than by a clock."""
    sooner = s1 if behind > 0.0 else s2
    if abs(behind) > LONGEST_DELIVERY or sooner.delivery < SOONEST_DELIVERY:
        return False
    if_late, if_apart = by_stamps(), together()
    if if_late is None and if_apart is None:
        return abs(behind) <= WITHOUT_MOTION
    return (if_late or 0.0) + abs(behind) / USUAL_DELIVERY <= (if_apart or 0.0) + CLOCKS_APART


def _steps(s1: Stamped, s2: Stamped, start_ns: int) -> list[Finding]:
    """Judge the steps of clocks, and the offset between the sensors' stamps after each."""
    findings = []
    for name, steps, others in (("s1", s1.steps, s2.steps), ("s2", s2.steps, s1.steps)):
        for step in steps:
            both = any(_is_same(step, each) for each in others)
            if both and name == "s2":
                continue
            findings.append(_step("s1 and s2" if both else name, step, start_ns, both))
    edges = sorted({each.at_ns for each in (*s1.steps, *s2.steps)})
    begins = [start_ns, *edges]
    ends = [*edges, 2**63 - 1]
    for begin_ns, end_ns in zip(begins, ends, strict=True):
        parts = [each.between(begin_ns, end_ns).samples for each in (s1, s2)]
        if all(each.values.size for each in parts):
            behind = _behind(*parts)
            if abs(behind) > STEP:
                since = (begin_ns - start_ns) * 1e-9
                findings.append(_apart(behind, f", from {since:.1f} s on" if since else ""))
    return findings


def _is_same(step: ClockStep, other: ClockStep) -> bool:
    near = abs(step.at_ns - other.at_ns) * 1e-9 <= TOGETHER
    return near and abs(step.by - other.by) <= STEP


def _step(who: str, step: ClockStep, start_ns: int, both: bool) -> Finding:
    way = "back" if step.by < 0.0 else "ahead"
    at_s = (step.at_ns - start_ns) * 1e-9
    jump = f"timestamps of {who} jump {way} by {duration(abs(step.by))} at {at_s:.1f} s"
    if both:
        remedy = f"--end {at_s:.1f} for the part before, --start {at_s:.1f} for the part after"
        return Finding(Level.INFO, "clock step", jump, {}, remedy)
    other = "s2" if who == "s1" else "s1"
    return Finding(Level.ERROR, "clock step", f"{jump}, those of {other} do not", {}, SYNCHRONIZE)


def _apart(behind: float, since: str = "") -> Finding:
    text = f"{apart(behind)} although both arrive together{since}"
    return Finding(Level.ERROR, "clock offset", text, {}, SYNCHRONIZE)


def _late(behind: float, s1: Stamped, s2: Stamped) -> Finding:
    late, other = (s2, s1) if behind > 0.0 else (s1, s2)
    name, stamps_ns = late.samples.name, late.samples.stamps_ns
    pause = bursts_of(seconds_since(int(stamps_ns[0]), np.unique(stamps_ns))).period
    text = (
        f"messages of {name} arrive {duration(late.delivery)} after their timestamps, those of "
        f"{other.samples.name} {duration(max(other.delivery, 0.0))}; {name}.timeout, if it is set, "
        f"must be longer than {duration(late.delivery + LOST_AFTER * pause)}"
    )
    return Finding(Level.INFO, "late delivery", text, {})
