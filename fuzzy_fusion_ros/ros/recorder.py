# SPDX-License-Identifier: Apache-2.0
"""Records what a node receives and publishes, byte for byte, as rosbag2 would."""

from __future__ import annotations

from typing import Protocol

from rclpy.qos import QoSProfile


class Recorder(Protocol):
    """Takes messages in the order in which the node met them.

    Attributes:
        records: Whether it keeps them.
    """

    records: bool

    def add(self, topic: str, type_name: str, qos: QoSProfile) -> None:
        """Declare a topic by its full name."""

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        """Record a message; a log time before that of the last message is raised to it."""

    def close(self) -> None:
        """Finish the bag."""


class NoRecorder:
    """Records nothing."""

    records = False

    def add(self, topic: str, type_name: str, qos: QoSProfile) -> None:
        """Do nothing."""

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""


class BagRecorder:
    """Records into a new bag directory."""

    records = True

    def __init__(self, path: str) -> None:
        """Create the bag.

        Raises:
            BagError: The directory is not empty or cannot be written.
        """
        from fuzzy_fusion_ros.bag import BagWriter  # loads rosbags and mcap, which few nodes need

        self._writer = BagWriter(path)
        self._types: dict[str, str] = {}
        self._newest_ns = 0

    def add(self, topic: str, type_name: str, qos: QoSProfile) -> None:
        """Declare a topic by its full name."""
        from fuzzy_fusion_ros.bag import offered_qos

        offered = offered_qos(qos.depth, qos.reliability.name.lower(), qos.durability.name.lower())
        self._types[topic] = type_name
        self._writer.add_topic(topic, type_name, qos=[offered])

    def write(self, topic: str, log_ns: int, data: bytes) -> None:
        """Record a message; its log time is never before that of the last one."""
        self._newest_ns = max(self._newest_ns, log_ns)
        self._writer.write(topic, self._types[topic], self._newest_ns, data)

    def close(self) -> None:
        """Finish the bag."""
        self._writer.close()


def recorder_for(path: str) -> Recorder:
    """Return a recorder into ``path``, one that records nothing if that is empty."""
    return BagRecorder(path) if path else NoRecorder()
