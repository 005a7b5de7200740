# SPDX-License-Identifier: Apache-2.0
"""What a node reports about one sensor."""

from __future__ import annotations

from typing import Any

from rclpy.impl.rcutils_logger import RcutilsLogger

from fuzzy_fusion_ros.nodes import silent_topic
from fuzzy_fusion_ros.nodes.sensor_input import SensorInput
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.statistics import Rate

LOST = "lost: queue overflow or dropped in transit"

SILENT = 5.0
"""Seconds without any message after which the log says so."""

INTERLEAVED = (Drop.NOT_NEWER, Drop.OTHER_TIMELINE)
"""Drops of samples that other publishers' samples have overtaken."""


class SensorReport:
    """Reports rate, age and losses of a sensor, and logs each kind of trouble once.

    WARN where the sensor is silent past its timeout, and where samples were dropped or messages
    lost since the last report.
    """

    def __init__(
        self, part: str, source: SensorInput, node: ConfiguredNode[Any], log: RcutilsLogger
    ) -> None:
        """Report on a sensor.

        Args:
            part: Its name in the status.
            source: Where its messages come in.
            node: The node that it belongs to.
            log: Where trouble is logged.
        """
        self._part = part
        self._source = source
        self._node = node
        self._logger = log
        self._rate = Rate()
        self._counts: dict[str, int] = {}
        self._logged: set[str] = set()

    def report(self, timeout: float) -> Report:
        """Report how the sensor is.

        Args:
            timeout: How long it may be silent, seconds.
        """
        source, guard = self._source, self._source.guard
        age = source.age
        texts = self._silence(age, timeout) + self._losses()
        last = guard.last_drop
        values: dict[str, object] = {
            "rate (Hz)": self._rate.of(source.subscription.received),
            "age (s)": age,
            "received": source.subscription.received,
            "admitted": guard.admitted,
            **self._counts,
            "last reason for a drop": last.value if last else "",
            "last unreadable message": source.last_problem,
        }
        summaries = [Summary(Level.WARN, text) for text in texts]
        return Report(self._part, summaries, values, source.subscription.topic)

    def _silence(self, age: float, timeout: float) -> list[str]:
        never = self._source.subscription.received == 0 and age > SILENT
        if age <= timeout and not never:
            return []
        reasons = list(silent_topic.reasons(self._node, self._source.subscription))
        if never:
            self._log("silence", "; ".join([f"no message received for {SILENT:g} s", *reasons]))
        return [f"silent for {age:.1f} s", *reasons] if age > timeout else []

    def _losses(self) -> list[str]:
        """Return what was dropped or lost since the last report."""
        guard, before = self._source.guard, self._counts
        self._counts = {f"dropped: {each.value}": guard.dropped[each] for each in Drop}
        self._counts[LOST] = self._source.subscription.lost
        texts = []
        for what, count in self._counts.items():
            if count > before.get(what, 0):
                texts.append(f"{count - before.get(what, 0)} {what}")
                self._log(what, f"{texts[-1]}; from now on counted in /diagnostics")
        if any(f"dropped: {each.value}" in text for text in texts for each in INTERLEAVED):
            texts += self._rivals()
        return texts

    def _rivals(self) -> list[str]:
        """Name the publishers where there is more than one."""
        publishers = self._source.subscription.publishers()
        if len(publishers) < 2:
            return []
        names = [f"{each.node_namespace.rstrip('/')}/{each.node_name}" for each in publishers]
        text = (
            f"{len(names)} publishers, {' and '.join(sorted(names))}, whose timestamps "
            "interleave: publish each sensor on its own topic"
        )
        self._log("publishers", text)
        return [text]

    def _log(self, kind: str, text: str) -> None:
        if kind not in self._logged:
            self._logged.add(kind)
            self._logger.warning(f"{self._source.subscription.topic}: {text}")
