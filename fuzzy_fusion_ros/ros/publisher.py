# SPDX-License-Identifier: Apache-2.0
"""A topic that a node publishes and, if it records, records."""

from __future__ import annotations

import copy
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.ros.qos import OUTPUT, OVERRIDABLE, log_unfit_subscription, overridable
from fuzzy_fusion_ros.ros.recorder import Recorder


class RecordingPublisher:
    """One published topic; the wire and the bag get the same bytes.

    Attributes:
        topic: Its full name, remapped or not.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        type_name: str,
        recorder: Recorder,
        profile: QoSProfile = OUTPUT,
        wanted: set[str] | None = None,
    ) -> None:
        """Publish on ``topic``, remapped or not.

        Args:
            node: The node that publishes.
            topic: The topic.
            type_name: Its type.
            recorder: What records it.
            profile: Quality of service; ``qos_overrides`` go on top.
            wanted: Holds the full name of the topic while anyone subscribes or records. It is kept
                by events, since asking costs time; publishers that share it are asked all at once.

        Raises:
            MessageError: The type is not installed.
        """
        message_type = load_message_class(type_name)
        self._recorder = recorder
        self._wanted = set() if wanted is None else wanted
        profile = copy.copy(profile)  # overrides are written into it
        events = PublisherEventCallbacks(
            incompatible_qos=lambda event: log_unfit_subscription(node, self.topic, profile, event),
            matched=self._on_matched,
        )
        with overridable(topic):
            self._publisher = node.create_publisher(
                message_type,
                topic,
                profile,
                event_callbacks=events,
                qos_overriding_options=OVERRIDABLE,
            )
        self.topic: str = self._publisher.topic_name
        recorder.add(self.topic, type_name, profile)
        self._note(recorder.records)

    @property
    def wanted(self) -> bool:
        """Whether anyone subscribes or records."""
        return self.topic in self._wanted

    @property
    def subscribers(self) -> int:
        """Matched subscriptions."""
        return int(self._publisher.get_subscription_count())

    def _on_matched(self, event: Any) -> None:
        self._note(self._recorder.records or event.current_count > 0)

    def _note(self, wanted: bool) -> None:
        (self._wanted.add if wanted else self._wanted.discard)(self.topic)

    def send(self, data: bytes, log_ns: int) -> None:
        """Publish a serialised message and record it at ``log_ns``."""
        self._publisher.publish(data)
        self._recorder.write(self.topic, log_ns, data)

    def flush(self, timeout: float) -> None:
        """Wait until reliable subscriptions have all messages, for ``timeout`` seconds at most."""
        self._publisher.wait_for_all_acked(Duration(seconds=timeout))
