"""What is said about one sensor."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary
from fuzzy_fusion_ros.ros.statistics import Rate
from fuzzy_fusion_ros.ros.subscription import SensorInput


class SensorReport:
    """Reports rate, age and losses of a sensor.

    WARN where the sensor is silent past its timeout, where samples were dropped or messages
    lost since the last report.
    """

    def __init__(
        self, part: str, source: SensorInput, guard: Guard, timeout: Callable[[], float]
    ) -> None:
        """Report on a sensor.

        Args:
            part: Its name in the status.
            source: Where its messages come in.
            guard: What admits its samples.
            timeout: Tells how long it may be silent, seconds.
        """
        self._part = part
        self._source = source
        self._guard = guard
        self._timeout = timeout
        self._rate = Rate()
        self._counts: dict[str, int] = {}

    def __call__(self) -> Iterator[Report]:
        """Say how the sensor is."""
        age, timeout = self._source.age, self._timeout()
        counts = self._current_counts()
        summaries = list(self._silence(age)) if age > timeout else []
        summaries += [
            Summary(Level.WARN, f"{count - self._counts.get(what, 0)} {what}")
            for what, count in counts.items()
            if count > self._counts.get(what, 0)
        ]
        self._counts = counts
        last = self._guard.last_drop
        values: dict[str, object] = {
            "rate (Hz)": self._rate.of(self._source.received),
            "age (s)": age,
            "received": self._source.received,
            "admitted": self._guard.admitted,
            **counts,
            "last reason for a drop": last.value if last else "",
            "last unreadable message": self._source.last_problem,
        }
        yield Report(self._part, summaries, values, self._source.topic)

    def _silence(self, age: float) -> Iterator[Summary]:
        yield Summary(Level.WARN, f"silent for {age:.1f} s")
        for other in self._source.other_types():
            ours = self._source.codec.type_name
            yield Summary(Level.WARN, f"is published as {other}, subscribed as {ours}")

    def _current_counts(self) -> dict[str, int]:
        counts = {f"dropped: {each.value}": self._guard.dropped[each] for each in Drop}
        counts["lost: came faster than they were taken, or went lost on the way"] = (
            self._source.lost
        )
        return counts
