# SPDX-License-Identifier: Apache-2.0
"""From exec to the first estimate, against the bare relay; also with nothing compiled yet."""

from __future__ import annotations

import functools
import tempfile
import time
from collections.abc import Iterator

from geometry_msgs.msg import PointStamped
from rclpy.qos import QoSProfile

from bench.child import module, program, running
from bench.effort import Effort
from bench.graph import Graph, graph
from bench.measuring import compared, interleaved
from bench.relay import EVENTS
from bench.table import Row, at_most
from bench.wire import sample, stamp_of

PERIOD = 0.01
"""Seconds between samples."""

NODE = program("fusion_node", "--ros-args", "-r", "__ns:=/start")
RELAY = module("relay", EVENTS, "sensor_data", "--ros-args", "-r", "__ns:=/start")

Times = tuple[float, float]
"""Wall and CPU time, seconds."""


class Sender:
    """Sends both found all the time, and notes when an answer comes."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        profile = QoSProfile(depth=10)
        self._s1 = graph.node.create_publisher(PointStamped, "/start/s1", profile)
        self._s2 = graph.node.create_publisher(PointStamped, "/start/s2", profile)
        self._answers = graph.node.create_subscription(
            PointStamped, "/start/estimate", self._on_answer, profile, raw=True
        )
        self._began_ns = 0
        self._answered = False

    def start(self, command: list[str], cold: bool) -> Times:
        """Start a process and wait for its first answer.

        Args:
            command: How to start it.
            cold: Whether Python finds nothing compiled, of any package: the first start ever.
        """
        self._graph.spin_until(lambda: self._answers.get_publisher_count() == 0)
        with tempfile.TemporaryDirectory() as empty:
            more = {"PYTHONPYCACHEPREFIX": empty} if cold else {}
            begin, self._began_ns, self._answered = time.monotonic(), time.time_ns(), False
            with running(command, {**self._graph.environment, **more}) as child:
                for _ in self._ticks(begin):
                    if self._answered:
                        return time.monotonic() - begin, child.cpu
        raise TimeoutError(f"no answer from {command}")

    def _ticks(self, begin: float) -> Iterator[None]:
        for k in range(6000):
            now_ns = time.time_ns()
            self._s2.publish(sample(now_ns, 0.1))
            self._s1.publish(sample(now_ns, 0.1))
            self._graph.spin_to(begin + (k + 1) * PERIOD)
            yield

    def _on_answer(self, data: bytes) -> None:
        self._answered |= stamp_of(data) > self._began_ns  # not one that still lies here


def rows(effort: Effort) -> list[Row]:
    """Measure start-up."""
    found = []
    with graph() as opened:
        sender = Sender(opened)
        for cold, name in ((False, "warm"), (True, "nothing compiled yet")):
            times: dict[str, list[Times]] = {"node": [], "relay": []}

            def note(who: str, command: list[str], cold: bool, to: dict[str, list[Times]]) -> float:
                to[who].append(sender.start(command, cold))
                return 0.0

            interleaved(
                effort.repetitions,
                functools.partial(note, "node", NODE, cold, times),
                functools.partial(note, "relay", RELAY, cold, times),
            )
            for column, kind, aim in ((0, "", at_most(1.0, "s more")), (1, ", CPU", None)):
                it = compared(
                    [each[column] for each in times["node"]],
                    [each[column] for each in times["relay"]],
                )
                found.append(
                    Row(
                        f"fusion_node from exec to first estimate, {name}{kind}",
                        f"{it.ours:.2f} s",
                        f"{it.against:.2f} s relay",
                        it.ours - it.against if aim else it.ratio,
                        aim,
                    )
                )
    return found
