"""The topics of the simulated plant and its sensors."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from fuzzy_fusion_ros.messages.outputs import POINT, point
from fuzzy_fusion_ros.messages.sample import SECOND_NS
from fuzzy_fusion_ros.nodes.outlet import Outlet, new_message
from fuzzy_fusion_ros.nodes.recorder import Recorder
from fuzzy_fusion_ros.simulation.closed_loop import Reading
from fuzzy_fusion_ros.simulation.pendulum import Pendulum

JOINT = "pole"

FIRST = 5.0
"""Longest wait until all reliable subscribers have the first sample of S2, seconds."""


class PlantTopics:
    """Publishes a sample of the plant, then what the controller makes of it.

    Attributes:
        s1: The topic of S1.
        s2: The topic of S2.
    """

    def __init__(self, node: Node, recorder: Recorder, *, clock: bool) -> None:
        self._truth = Outlet(node, "truth", POINT, recorder)
        self._joints = Outlet(node, "joint_states", "sensor_msgs/msg/JointState", recorder)
        self._clock = Outlet(node, "/clock", "rosgraph_msgs/msg/Clock", recorder) if clock else None
        self.s2 = Outlet(node, "s2", POINT, recorder)
        self.s1 = Outlet(node, "s1", POINT, recorder)
        self._control = Outlet(node, "control", POINT, recorder)
        self._began = False

    def send_sample(self, stamp_ns: int, plant: Pendulum, reading: Reading) -> None:
        """Publish the truth and both sensors, S1 last: it makes the estimate due."""
        self._truth.send(point(new_message, stamp_ns, plant.angle), stamp_ns)
        self._joints.send(_joint_state(stamp_ns, plant), stamp_ns)
        if self._clock is not None:
            clock = Clock()
            clock.clock.sec, clock.clock.nanosec = divmod(stamp_ns, SECOND_NS)
            self._clock.send(clock, stamp_ns)
        self.s2.send(point(new_message, stamp_ns, reading.s2), stamp_ns)
        if not self._began:  # the first must not come after S1's, whoever is known first
            self._began = True
            self.s2.flush(FIRST)
        self.s1.send(point(new_message, stamp_ns, reading.s1), stamp_ns)

    def send_control(self, stamp_ns: int, force: float) -> None:
        """Publish the force on the cart, N."""
        self._control.send(point(new_message, stamp_ns, force), stamp_ns)

    def flush(self, timeout: float) -> None:
        """Wait until reliable subscribers have what was sent, for at most ``timeout`` seconds."""
        for outlet in (self._truth, self._joints, self._control):
            outlet.flush(timeout)


def _joint_state(stamp_ns: int, plant: Pendulum) -> Any:
    message = JointState(name=[JOINT], position=[plant.angle], velocity=[plant.rate])
    stamp = message.header.stamp
    stamp.sec, stamp.nanosec = divmod(stamp_ns, SECOND_NS)
    return message
