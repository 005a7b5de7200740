"""A topic that a node publishes and, if it records, records."""

from __future__ import annotations

import copy
from typing import Any

from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.serialization import serialize_message

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.cdr import padding_eraser
from fuzzy_fusion_ros.nodes.qos import OUTPUT, OVERRIDABLE, overridable
from fuzzy_fusion_ros.nodes.recorder import Recorder


class Outlet:
    """One published topic; a message is serialised once for the wire and the bag.

    The same message always has the same bytes.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        type_name: str,
        recorder: Recorder,
        profile: QoSProfile = OUTPUT,
    ) -> None:
        """Publish on ``topic``, remapped or not.

        Raises:
            MessageError: The type is not installed.
        """
        message_type = load_message_class(type_name)
        profile = copy.copy(profile)  # overrides are written into it
        with overridable(topic):
            self._publisher = node.create_publisher(
                message_type, topic, profile, qos_overriding_options=OVERRIDABLE
            )
        self.topic: str = self._publisher.topic_name
        self._clean = padding_eraser(type_name)
        self._recorder = recorder
        recorder.add(self.topic, type_name, profile)

    @property
    def wanted(self) -> bool:
        """Whether anyone subscribes or records."""
        return self._recorder.records or self.subscribers > 0

    @property
    def subscribers(self) -> int:
        """Matched subscriptions."""
        return int(self._publisher.get_subscription_count())

    def send(self, message: Any, log_ns: int) -> None:
        """Publish a message and record it at ``log_ns``."""
        data = self._clean(serialize_message(message))
        self._publisher.publish(data)
        self._recorder.write(self.topic, log_ns, data)

    def flush(self, timeout: float) -> None:
        """Wait until reliable subscriptions have all messages, for ``timeout`` seconds at most."""
        self._publisher.wait_for_all_acked(Duration(seconds=timeout))


def new_message(type_name: str) -> Any:
    """Return a blank message of an installed type.

    Raises:
        MessageError: It is not installed.
    """
    return load_message_class(type_name)()
