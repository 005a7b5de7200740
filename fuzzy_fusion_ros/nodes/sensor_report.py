"""What a node reports about one sensor."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzy_fusion_ros.nodes.sensor_input import SensorInput
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary
from fuzzy_fusion_ros.ros.statistics import Rate

LOST = "lost: queue overflow or dropped in transit"


class SensorReport:
    """Reports rate, age and losses of a sensor.

    WARN where the sensor is silent past its timeout, and where samples were dropped or messages
    lost since the last report.
    """

    def __init__(self, part: str, source: SensorInput) -> None:
        """Report on a sensor.

        Args:
            part: Its name in the status.
            source: Where its messages come in.
        """
        self._part = part
        self._source = source
        self._rate = Rate()
        self._counts: dict[str, int] = {}

    def report(self, timeout: float) -> Report:
        """Report how the sensor is.

        Args:
            timeout: How long it may be silent, seconds.
        """
        source, guard = self._source, self._source.guard
        age = source.age
        counts = self._current_counts()
        summaries = list(self._silence(age)) if age > timeout else []
        summaries += [
            Summary(Level.WARN, f"{count - self._counts.get(what, 0)} {what}")
            for what, count in counts.items()
            if count > self._counts.get(what, 0)
        ]
        self._counts = counts
        last = guard.last_drop
        values: dict[str, object] = {
            "rate (Hz)": self._rate.of(source.subscription.received),
            "age (s)": age,
            "received": source.subscription.received,
            "admitted": guard.admitted,
            **counts,
            "last reason for a drop": last.value if last else "",
            "last unreadable message": source.last_problem,
        }
        return Report(self._part, summaries, values, source.subscription.topic)

    def _silence(self, age: float) -> Iterator[Summary]:
        yield Summary(Level.WARN, f"silent for {age:.1f} s")
        ours = self._source.subscription.type_name
        for other in sorted({each.topic_type for each in self._source.subscription.publishers()}):
            if other != ours:
                yield Summary(Level.WARN, f"published as {other}, subscribed as {ours}")

    def _current_counts(self) -> dict[str, int]:
        counts = {f"dropped: {each.value}": self._source.guard.dropped[each] for each in Drop}
        counts[LOST] = self._source.subscription.lost
        return counts
