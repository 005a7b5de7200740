"""The guard in front of each sensor: what may not reach the method is named and counted."""

from __future__ import annotations

import enum
import math
from collections import Counter
from collections.abc import Callable

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample

OLDER_IN_A_ROW = 5
"""So many samples that are older than the last, but rise among themselves, are a new timeline."""


class Drop(enum.Enum):
    """Why a sample was dropped."""

    NOT_FINITE = "value is not finite"
    ZERO_STAMP = "stamp is zero"
    FUTURE_STAMP = "stamp is too far in the future"
    NOT_NEWER = "stamp is not newer than the last"
    UNPAIRED = "no partner with an equal stamp"
    UNREADABLE = "message lacks the field"


class Guard:
    """Admits the samples of one sensor in rising order of stamps.

    Attributes:
        first_ns: Stamp of the first sample admitted since the last restart, 0 before it.
        newest_ns: Stamp of the last admitted sample, ``None`` before the first.
        admitted: Samples admitted since construction.
        dropped: Samples dropped since construction, by reason.
        last_drop: The last reason, ``None`` if there was none.
    """

    def __init__(self) -> None:
        self.admitted = 0
        self.dropped: Counter[Drop] = Counter()
        self.last_drop: Drop | None = None
        self.restart()

    def restart(self) -> None:
        """Forget the timeline, keep the counts."""
        self.first_ns = 0
        self.newest_ns: int | None = None
        self._in_a_row = 0
        self._older_ns = 0
        self._older_in_a_row = 0

    def take(
        self,
        sample: Sample,
        now_ns: int,
        future_tolerance: float,
        jump_tolerance: float,
        on_jump: Callable[[], None],
    ) -> bool:
        """Admit a sample, or drop it and count why; return whether it is admitted.

        Args:
            sample: The sample as it came.
            now_ns: Time of receipt on the clock of the stamps, nanoseconds.
            future_tolerance: As :meth:`fault` takes it, seconds.
            jump_tolerance: As :meth:`jumped_back` takes it, seconds.
            on_jump: Called when the sample opens a new timeline; it must restart this guard.
        """
        fault = self.fault(sample.stamp_ns, sample.value, now_ns, future_tolerance)
        if fault is None and self.jumped_back(sample.stamp_ns, jump_tolerance):
            on_jump()
        if fault is None and not self.admit(sample.stamp_ns):
            fault = Drop.NOT_NEWER
        if fault is not None:
            self.drop(fault)
        return fault is None

    def fault(
        self, stamp_ns: int, value: float, now_ns: int, future_tolerance: float
    ) -> Drop | None:
        """Return why a sample can never be used, whatever came before it.

        Args:
            stamp_ns: Its stamp, nanoseconds.
            value: Its value, NaN and infinities included.
            now_ns: Time of receipt on the clock of the stamps, nanoseconds.
            future_tolerance: How far stamps may be ahead of ``now_ns``, seconds.
        """
        if not math.isfinite(value):
            return Drop.NOT_FINITE
        if stamp_ns == 0:
            return Drop.ZERO_STAMP
        if seconds_between(now_ns, stamp_ns) > future_tolerance:
            return Drop.FUTURE_STAMP
        return None

    def jumped_back(self, stamp_ns: int, tolerance: float) -> bool:
        """Return whether a stamp opens a new timeline rather than being late in this one.

        It does when it is older than the last by more than ``tolerance`` seconds, when it is
        no newer than the first of many, as in a looped recording, or when it is the last of
        ``OLDER_IN_A_ROW`` older ones that rise among themselves.
        """
        if self.newest_ns is None or stamp_ns >= self.newest_ns:
            self._older_in_a_row = 0
            return False
        rises = self._older_in_a_row == 0 or stamp_ns > self._older_ns
        self._older_in_a_row = self._older_in_a_row + 1 if rises else 1
        self._older_ns = stamp_ns
        return (
            seconds_between(stamp_ns, self.newest_ns) > tolerance
            or (stamp_ns <= self.first_ns and self._in_a_row >= OLDER_IN_A_ROW)
            or self._older_in_a_row >= OLDER_IN_A_ROW
        )

    def admit(self, stamp_ns: int) -> bool:
        """Admit a sample if it is newer than the last; else it is to be dropped."""
        if self.newest_ns is not None and stamp_ns <= self.newest_ns:
            return False
        if self.newest_ns is None:
            self.first_ns = stamp_ns
        self.newest_ns = stamp_ns
        self._in_a_row += 1
        self.admitted += 1
        return True

    def drop(self, reason: Drop, samples: int = 1) -> None:
        """Count dropped samples, which may be none."""
        if samples > 0:
            self.dropped[reason] += samples
            self.last_drop = reason
