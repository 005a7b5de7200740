# SPDX-License-Identifier: Apache-2.0
"""The timeline that the sensors of a node share: what is on it, and when a new one starts.

A stamp before the newest of its sensor is either late or the first of a new timeline: a looped
recording, a reset simulation. One stamp cannot decide, so the sample is held until the next ones
do: either the old timeline continues and the held samples are dropped, or they are the start of the
new timeline and none of it is lost.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import DELAYS, Drop, Guard

LATE = 1.0
"""Stamps older than the newest by up to this many seconds may be late in the same timeline."""

EVIDENCE = 3
"""Held samples of one sensor in a row that start a new timeline; one of each of two suffices."""

LATE_EVIDENCE = 5
"""The same where the samples may only be late."""

MOST_EVIDENCE = 64
"""The same while two timelines interleave, as of two publishers with different clocks."""

CALM = 1000
"""Consecutive samples on one timeline after which nothing interleaves any more."""


class Admission(NamedTuple):
    """What happened to a sample.

    Attributes:
        admitted: The samples admitted now, each with its guard: those held before it, then it.
        drop: Why it was dropped, if it was.
        restarted: Whether the admitted samples start a new timeline.
    """

    admitted: tuple[tuple[Guard, Sample], ...] = ()
    drop: Drop | None = None
    restarted: bool = False


HELD = Admission()
"""Neither admitted nor dropped yet."""


class Timeline:
    """Admits the samples of some sensors in rising order of stamps, per sensor."""

    def __init__(self, *guards: Guard) -> None:
        self._guards = guards
        self._held: list[tuple[Guard, Sample]] = []
        self._evidence = EVIDENCE
        self._calm = 0

    def receive(
        self, guard: Guard, sample: Sample, now_ns: int, future_tolerance: float
    ) -> Admission:
        """Admit, hold or drop a sample.

        Args:
            guard: The guard of its sensor.
            sample: The sample as it came.
            now_ns: Time of receipt on the clock of the stamps, nanoseconds.
            future_tolerance: How far stamps may be ahead of that, seconds.
        """
        if sample.stamp_ns > 0:
            guard.delays_ns.append(now_ns - sample.stamp_ns)
        drop = guard.fault(sample, now_ns, future_tolerance)
        if drop is not None:
            guard.drop(drop)
            return Admission(drop=drop)
        if self._is_off(guard, sample.stamp_ns):
            return self._hold(guard, sample)
        if self._held or self._evidence > EVIDENCE:
            self._go_on(guard)
        guard.admit(sample.stamp_ns)
        return Admission(((guard, sample),))

    @property
    def is_settled(self) -> bool:
        """Whether no sample is held, and no evidence points to another timeline."""
        return not self._held and self._evidence == EVIDENCE

    def restart(self) -> Admission:
        """Start a new timeline with the samples that are held."""
        held, self._held = tuple(self._held), []
        if any(guard.left_ns and sample.stamp_ns > guard.left_ns for guard, sample in held):
            self._interleave()
        for guard in self._guards:
            guard.restart()
            own = sum(owner is guard for owner, _ in held)  # of the new time, so they count
            delays_ns = list(guard.delays_ns)
            guard.delays_ns = deque(delays_ns[len(delays_ns) - own :], DELAYS)
        for guard, sample in held:
            guard.admit(sample.stamp_ns)
        return Admission(held, restarted=True)

    def reset(self) -> None:
        """Forget the timeline and drop what is held."""
        self.finish()
        self._evidence = EVIDENCE
        for guard in self._guards:
            guard.restart()
            guard.left_ns = None

    def finish(self) -> None:
        """Drop what is held: nothing more will come."""
        for guard in self._guards:
            self._give_up(guard)

    def _is_off(self, guard: Guard, stamp_ns: int) -> bool:
        """Return whether a stamp does not continue the timeline."""
        newest_ns = guard.newest_ns
        if newest_ns is None:
            return False
        if stamp_ns < newest_ns:
            return True
        is_left = guard.left_ns is not None and stamp_ns > guard.left_ns
        return is_left and seconds_between(newest_ns, stamp_ns) > LATE

    def _hold(self, guard: Guard, sample: Sample) -> Admission:
        own = [each for owner, each in self._held if owner is guard]
        if own and sample.stamp_ns <= own[-1].stamp_ns:
            self._give_up(guard)
            own = []
        self._held.append((guard, sample))
        own.append(sample)
        if self._is_far(guard, own[0].stamp_ns):
            agreed = self._evidence == EVIDENCE and any(
                owner is not guard and self._is_far(owner, each.stamp_ns)
                for owner, each in self._held
            )
            enough = agreed or len(own) >= self._evidence
        else:
            enough = len(own) >= max(self._evidence, LATE_EVIDENCE)
        return self.restart() if enough else HELD

    def _is_far(self, guard: Guard, stamp_ns: int) -> bool:
        """Return whether a held stamp is too far off to be late in the same timeline.

        However short a looped recording is: no newer than the first of many cannot be late.
        """
        newest_ns = guard.newest_ns or 0
        return (
            stamp_ns > newest_ns
            or seconds_between(stamp_ns, newest_ns) > LATE
            or (stamp_ns <= guard.first_ns and guard.in_a_row >= LATE_EVIDENCE)
        )

    def _go_on(self, guard: Guard) -> None:
        """Note that the timeline continues, so that the held samples were not part of it."""
        self._calm += 1
        if self._give_up(guard) and guard.left_ns is not None:
            self._interleave()
        elif self._calm >= CALM:
            self._evidence = EVIDENCE

    def _interleave(self) -> None:
        """Require more evidence: the timeline that was left continues in parallel."""
        self._evidence = min(2 * self._evidence, MOST_EVIDENCE)
        self._calm = 0

    def _give_up(self, guard: Guard) -> int:
        """Drop what is held of a sensor; return how much that was."""
        own = [each.stamp_ns for owner, each in self._held if owner is guard]
        self._held = [each for each in self._held if each[0] is not guard]
        newest_ns = guard.newest_ns or 0
        late = sum(stamp_ns <= newest_ns for stamp_ns in own)
        guard.drop(Drop.NOT_NEWER, late)
        guard.drop(Drop.OTHER_TIMELINE, len(own) - late)
        return len(own)
