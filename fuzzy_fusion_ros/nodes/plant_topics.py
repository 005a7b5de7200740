# SPDX-License-Identifier: Apache-2.0
"""The topics of the simulated plant and its sensors."""

from __future__ import annotations

from rclpy.node import Node

from fuzzy_fusion_ros.messages import InstalledTypes
from fuzzy_fusion_ros.messages.cdr import CdrWriter
from fuzzy_fusion_ros.messages.outputs import POINT, point_template
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher
from fuzzy_fusion_ros.ros.recorder import Recorder
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
        self._truth = RecordingPublisher(node, "truth", POINT, recorder)
        self._joints = RecordingPublisher(
            node, "joint_states", "sensor_msgs/msg/JointState", recorder
        )
        self._clock = (
            RecordingPublisher(node, "/clock", "rosgraph_msgs/msg/Clock", recorder)
            if clock
            else None
        )
        self.s2 = RecordingPublisher(node, "s2", POINT, recorder)
        self.s1 = RecordingPublisher(node, "s1", POINT, recorder)
        self._control = RecordingPublisher(node, "control", POINT, recorder)
        self._began = False
        self._point = point_template(InstalledTypes())

    def send_sample(self, stamp_ns: int, plant: Pendulum, reading: Reading) -> None:
        """Publish the truth and both sensors, S1 last: it makes the estimate due."""
        self._truth.send(self._point.filled(plant.angle, stamp_ns), stamp_ns)
        self._joints.send(_joint_state(stamp_ns, plant), stamp_ns)
        if self._clock is not None:
            self._clock.send(CdrWriter().stamp(stamp_ns).done(), stamp_ns)
        self.s2.send(self._point.filled(reading.s2, stamp_ns), stamp_ns)
        if not self._began:  # the first must not come after S1's, whoever is known first
            self._began = True
            self.s2.flush(FIRST)
        self.s1.send(self._point.filled(reading.s1, stamp_ns), stamp_ns)

    def send_control(self, stamp_ns: int, force: float) -> None:
        """Publish the force on the cart, N."""
        self._control.send(self._point.filled(force, stamp_ns), stamp_ns)

    def flush(self, timeout: float) -> None:
        """Wait until reliable subscribers have what was sent, for at most ``timeout`` seconds."""
        for publisher in (self._truth, self._joints, self._control):
            publisher.flush(timeout)


def _joint_state(stamp_ns: int, plant: Pendulum) -> bytes:
    """Return a ``sensor_msgs/msg/JointState`` without a frame and without effort."""
    writer = CdrWriter().stamp(stamp_ns).text("").count(1).text(JOINT)
    for number in (plant.angle, plant.rate):
        writer.count(1).number("float64", number)
    return writer.count(0).done()
