# SPDX-License-Identifier: Apache-2.0
"""The guard of each sensor: unusable samples are dropped, named and counted."""

from __future__ import annotations

import enum
import math
import statistics
from collections import Counter, deque
from collections.abc import Sequence

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.errors import MessageError, StampError

DELAYS = 32
"""Most recent samples whose delay from stamp to arrival is kept."""

FEWEST_DELAYS = 3
"""With fewer samples, nothing can be said about a sensor's clock."""


class Drop(enum.Enum):
    """Why a sample was dropped."""

    NOT_FINITE = "value is not finite"
    ZERO_STAMP = "stamp is zero"
    NEGATIVE_STAMP = "stamp is negative: before 1970, or seconds past 2038 in a signed field"
    BAD_NANOSECONDS = "nanoseconds of the stamp are 1e9 or more"
    FUTURE_STAMP = "stamp is too far in the future"
    NOT_NEWER = "stamp is not newer than the last"
    OTHER_TIMELINE = "stamp belongs to another timeline"
    UNPAIRED = "no partner with an equal stamp"
    UNREADABLE = "message lacks the field"

    @classmethod
    def of(cls, error: MessageError) -> Drop:
        """Return the reason for an error in reading a message."""
        return cls.BAD_NANOSECONDS if isinstance(error, StampError) else cls.UNREADABLE


class Guard:
    """Checks the samples of one sensor and counts what became of them.

    Attributes:
        first_ns: Stamp of the first sample admitted since the last restart, 0 before it.
        newest_ns: Stamp of the last admitted sample, ``None`` before the first.
        left_ns: Newest stamp of the timeline that the last restart left, ``None`` once it has
            been passed.
        in_a_row: Samples admitted since the last restart.
        admitted: Samples admitted since construction.
        dropped: Samples dropped since construction, by reason.
        last_drop: The last reason, ``None`` if there was none.
        delays_ns: How long after their stamps the newest samples arrived, nanoseconds.
    """

    def __init__(self, shortest_timeout: float = S1_TIMEOUT) -> None:
        """Guard a sensor.

        Args:
            shortest_timeout: The shortest automatic timeout of the sensor, seconds.
        """
        self._shortest_timeout = shortest_timeout
        self._interval = 0.0
        self.admitted = 0
        self.dropped: Counter[Drop] = Counter()
        self.last_drop: Drop | None = None
        self.newest_ns: int | None = None
        self.delays_ns: deque[int] = deque(maxlen=DELAYS)
        self.restart()

    def restart(self) -> None:
        """Start a new timeline; the counts stay."""
        self.left_ns = self.newest_ns
        self.newest_ns = None
        self.first_ns = 0
        self.in_a_row = 0
        self._interval = 0.0

    def fault(self, sample: Sample, now_ns: int, future_tolerance: float) -> Drop | None:
        """Return why a sample cannot be used whatever came before it, ``None`` if it can.

        Args:
            sample: The sample; its value may be NaN or infinite.
            now_ns: Time of receipt on the clock of the stamps, nanoseconds.
            future_tolerance: How far stamps may be ahead of ``now_ns``, seconds.
        """
        stamp_ns = sample.stamp_ns
        if not math.isfinite(sample.value):
            return Drop.NOT_FINITE
        if stamp_ns <= 0:
            return Drop.NEGATIVE_STAMP if stamp_ns < 0 else Drop.ZERO_STAMP
        if seconds_between(now_ns, stamp_ns) > future_tolerance:
            return Drop.FUTURE_STAMP
        return Drop.NOT_NEWER if stamp_ns == self.newest_ns else None

    @property
    def delay(self) -> float | None:
        """How long after their stamps samples arrive, seconds; ``None`` while too few have."""
        if len(self.delays_ns) < FEWEST_DELAYS:
            return None
        return statistics.median(self.delays_ns) * 1e-9

    @property
    def delay_growth(self) -> float:
        """How far their median moves from the older half of them to the newer, seconds."""
        if len(self.delays_ns) < FEWEST_DELAYS:
            return 0.0
        delays_ns = [*self.delays_ns]
        half = len(delays_ns) // 2
        return (statistics.median(delays_ns[half:]) - statistics.median(delays_ns[:half])) * 1e-9

    def admit(self, stamp_ns: int) -> None:
        """Admit a sample that is newer than the last."""
        if self.newest_ns is None:
            self.first_ns = stamp_ns
        else:
            self._interval = followed(self._interval, seconds_between(self.newest_ns, stamp_ns))
        self.newest_ns = stamp_ns
        if self.left_ns is not None and stamp_ns >= self.left_ns:
            self.left_ns = None
        self.in_a_row += 1
        self.admitted += 1

    @property
    def interval(self) -> float:
        """Time between samples, followed, seconds; 0 before the second."""
        return self._interval

    def admit_run(
        self,
        first_ns: int,
        newest_ns: int,
        samples: int,
        interval: float,
        delays_ns: Sequence[int],
    ) -> None:
        """Admit a run of samples of one timeline, each newer than the last.

        Args:
            first_ns: Stamp of the first.
            newest_ns: Stamp of the last; a timeline that was left goes on after it, if at all.
            samples: How many they are.
            interval: Time between samples after them, followed, seconds.
            delays_ns: How long after their stamps the newest of them arrived, nanoseconds.
        """
        if self.newest_ns is None:
            self.first_ns = first_ns
        self.newest_ns = newest_ns
        self._interval = interval
        self.in_a_row += samples
        self.admitted += samples
        self.delays_ns.extend(delays_ns)

    def timeout(self, configured: float) -> float:
        """Return after how long without a sample the sensor counts as lost, seconds.

        Args:
            configured: The parameter; 0 is automatic.
        """
        return timeout_for(configured, self._shortest_timeout, self._interval)

    def drop(self, reason: Drop, samples: int = 1) -> None:
        """Count dropped samples; there may be none."""
        if samples > 0:
            self.dropped[reason] += samples
            self.last_drop = reason
