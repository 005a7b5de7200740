# SPDX-License-Identifier: Apache-2.0
"""What a node reports on /diagnostics, once a second (REP-107)."""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.qos import OUTPUT

PERIOD = 1.0
"""Seconds between two reports."""


class Level(enum.IntEnum):
    """How bad it is, as in ``diagnostic_msgs``."""

    OK = 0
    WARN = 1
    ERROR = 2


class Summary(NamedTuple):
    """One thing to say."""

    level: Level
    text: str


class Report(NamedTuple):
    """One status: what there is to say about a part, and its numbers.

    Attributes:
        part: The part of the node; the status is named ``node: part``.
        summaries: What there is to say; the worst gives the level.
        values: Numbers and texts by their names.
        hardware: What it is about, such as a topic.
    """

    part: str
    summaries: Sequence[Summary]
    values: Mapping[str, object]
    hardware: str = ""


class Diagnostics:
    """Publishes reports, by a timer that does not stop when the clock steps back."""

    def __init__(
        self, node: Node, node_time: NodeTime, reports: Callable[[], Iterable[Report]]
    ) -> None:
        """Start reporting.

        Args:
            node: The node.
            node_time: Its clocks.
            reports: Called once a second.
        """
        self._node = node
        self._reports = reports
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", OUTPUT)
        self._timer = node_time.every(PERIOD, self.publish)

    def publish(self) -> None:
        """Publish the reports."""
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        name = self._node.get_name()
        message.status = [_status(name, report) for report in self._reports()]
        self._publisher.publish(message)


def _status(node_name: str, report: Report) -> Any:
    summaries = sorted(report.summaries, key=lambda summary: -summary.level)
    level = summaries[0].level if summaries else Level.OK
    return DiagnosticStatus(
        level=bytes([level]),
        name=f"{node_name}: {report.part}",
        message="; ".join(summary.text for summary in summaries) or "OK",
        hardware_id=report.hardware,
        values=[KeyValue(key=key, value=_text(value)) for key, value in report.values.items()],
    )


def _text(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
