# SPDX-License-Identifier: Apache-2.0
"""The closed loop in lockstep over DDS, against a bare ping-pong of the same messages.

Both ends are processes: here the plant, or the ping; in a child fusion_node, or the relay.
"""

from __future__ import annotations

import contextlib
import time

from geometry_msgs.msg import PointStamped
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from sensor_msgs.msg import JointState

from bench.child import module, program, running
from bench.effort import Effort
from bench.graph import Graph, graph
from bench.measuring import compared, interleaved
from bench.relay import EVENTS
from bench.table import Row, at_least
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.ros.qos import ESTIMATE, OUTPUT

SAMPLE_TIME = 0.01
FIRST_TURNS = 10
"""Turns before the clock starts: discovery is behind us then."""

PROFILE = "reliable"
"""Of the inputs at the other end: a lost sample would stop the ping-pong."""


class Ping:
    """Publishes what the pendulum publishes in each turn, and begins the next at each answer."""

    def __init__(self, graph: Graph, namespace: str) -> None:
        self._graph = graph
        create = graph.node.create_publisher
        self._before = [
            (create(PointStamped, f"{namespace}/truth", OUTPUT), PointStamped()),
            (create(JointState, f"{namespace}/joint_states", OUTPUT), _joint_state()),
        ]
        self._s2 = create(PointStamped, f"{namespace}/s2", OUTPUT)
        self._s1 = create(PointStamped, f"{namespace}/s1", OUTPUT)
        self._control = create(PointStamped, f"{namespace}/control", OUTPUT)
        self._answers = graph.node.create_subscription(
            PointStamped,
            f"{namespace}/estimate",
            self._on_answer,
            QoSProfile(depth=10, durability=ESTIMATE.durability),
        )
        self._point = PointStamped()
        self.turns = self._last = 0

    @property
    def matched(self) -> bool:
        """Whether the relay is there."""
        ends = (self._s1.get_subscription_count(), self._s2.get_subscription_count())
        return min(*ends, self._answers.get_publisher_count()) > 0

    def run(self, turns: int) -> float:
        """Return turns per second."""
        self._graph.spin_until(lambda: self.matched)
        self._graph.spin_to(time.monotonic() + 0.5)  # for the relay to know us too
        self.turns, self._last = 0, turns
        self._turn()
        self._graph.spin_until(lambda: self.turns >= FIRST_TURNS)
        begin, done = time.monotonic(), self.turns
        self._graph.spin_until(lambda: self.turns >= turns)
        return (self.turns - done) / (time.monotonic() - begin)

    def _turn(self) -> None:
        for publisher, message in self._before:
            publisher.publish(message)
        self._s2.publish(self._point)
        self._s1.publish(self._point)

    def _on_answer(self, message: PointStamped) -> None:
        self.turns += 1
        self._control.publish(message)
        if self.turns < self._last:
            self._turn()


def _joint_state() -> JointState:
    return JointState(name=["pole"], position=[0.1], velocity=[0.1])


def rows(effort: Effort) -> list[Row]:
    """Measure turns per second."""
    with graph() as opened, contextlib.ExitStack() as stack:

        def start(command: list[str]) -> None:
            stack.enter_context(running(command, opened.environment))

        reliable = ["-p", f"qos:={PROFILE}"]
        predicting = ["-p", "predictor.enabled:=true"]
        start(program("fusion_node", "--ros-args", "-r", "__ns:=/fa", *reliable))
        start(program("fusion_node", "--ros-args", "-r", "__ns:=/both", *reliable, *predicting))
        start(module("relay", EVENTS, PROFILE, "--ros-args", "-r", "__ns:=/ping"))
        ping = Ping(opened, "/ping")
        fa, complete, bare = interleaved(
            effort.repetitions,
            lambda: pendulum(opened, "/fa", effort.loops),
            lambda: pendulum(opened, "/both", effort.loops),
            lambda: ping.run(effort.loops),
        )
    found = []
    for name, rates in (("FA alone", fa), ("complete", complete)):
        it = compared(rates, bare)
        what = f"lockstep closed loop over DDS, {name}"
        ours = f"{it.ours:.0f} turns/s"
        found.append(
            Row(what, ours, f"{it.against:.0f} /s bare ping-pong", it.ratio, at_least(0.8))
        )
        times = it.ours * SAMPLE_TIME
        found.append(Row(what, ours, "100 Hz, real time", times, at_least(20.0, "× real time")))
    return found


def pendulum(graph: Graph, namespace: str, turns: int) -> float:
    """Return turns per second of the closed loop."""
    values = {"duration": turns * SAMPLE_TIME, "timeout": 60.0}
    node = PendulumNode(
        context=graph.context,
        namespace=namespace,
        parameter_overrides=[Parameter(name, value=value) for name, value in values.items()],
    )
    graph.executor.add_node(node)
    try:
        graph.spin_until(lambda: node._run.samples >= FIRST_TURNS or node.failure)
        begin, done = time.monotonic(), node._run.samples
        graph.spin_until(lambda: node._run.samples >= turns or node.finished)
        rate = (node._run.samples - done) / (time.monotonic() - begin)
        graph.spin_until(lambda: node.finished)
    finally:
        graph.executor.remove_node(node)
        node.destroy_node()
    if node.failure is not None:
        raise node.failure
    return rate
