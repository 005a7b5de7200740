# SPDX-License-Identifier: Apache-2.0
"""A subscription to serialised messages: bounded under overload, and every loss counted."""

from __future__ import annotations

import inspect
import time
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.ros.backlog import Backlog
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.qos import OVERRIDABLE, log_unfit_publisher, overridable
from fuzzy_fusion_ros.ros.sequence_gaps import SequenceGapCounter
from fuzzy_fusion_ros.ros.statistics import WorkTime


class RawSubscription:
    """Hands each message of a topic, as bytes, to one method of a node.

    A :class:`FusionError` of that method ends the node.

    Attributes:
        topic: The full name of the topic.
        type_name: Its type.
        profile: The quality of service asked for.
        received: Messages handed on.
        work: How long that took.
    """

    # rclpy passes the message info to callbacks of two arguments.
    __signature__ = inspect.signature(lambda message, info: None)

    def __init__(
        self,
        node: ConfiguredNode[Any],
        topic: str,
        type_name: str,
        profile: QoSProfile,
        on_message: Callable[[bytes], None],
    ) -> None:
        """Subscribe.

        Args:
            node: The node to subscribe for.
            topic: The topic, remapped or not.
            type_name: Its type, installed.
            profile: Quality of service; ``qos_overrides`` go on top.
            on_message: Called with each message.

        Raises:
            MessageError: The type is not installed.
            ParameterError: A ``qos_overrides`` parameter is wrong.
        """
        self.type_name = type_name
        self.profile = profile
        self.received = 0
        self.work = WorkTime()
        self._node = node
        self._on_message = on_message
        self._gaps = SequenceGapCounter()
        self._backlog = Backlog()
        with overridable(topic):
            self._subscription = node.create_subscription(
                load_message_class(type_name),
                topic,
                self,
                profile,
                event_callbacks=SubscriptionEventCallbacks(
                    incompatible_qos=self._on_incompatible_qos, message_lost=self._on_lost
                ),
                qos_overriding_options=OVERRIDABLE,
                raw=True,
            )
        self.topic: str = self._subscription.topic_name

    @property
    def lost(self) -> int:
        """Messages that were published but never handed on."""
        return self._gaps.count + self._backlog.shed

    def publishers(self) -> list[Any]:
        """Return what is known of the topic's publishers: names, types, profiles."""
        return list(self._node.get_publishers_info_by_topic(self.topic))

    def __call__(self, message: Any, info: Any = None) -> None:
        """Receive a message: count what is missing before it, then handle or hold it."""
        if info is None:  # Jazzy's EventsExecutor passes both as one tuple
            message, info = message
        missing = self._gaps.before(info["publication_sequence_number"])
        if missing and self._subscription.get_publisher_count() <= 1:
            self._gaps.add(missing)
        if self._backlog.holds(message):
            return
        if self._backlog.needs_probe() and self._node.executor is not None:
            self._backlog.probed()
            self._node.executor.create_task(self._on_probe)
        self._handle(message)

    def _handle(self, data: bytes) -> None:
        if self._node.finished:
            return
        self.received += 1
        start = time.perf_counter()
        try:
            self._on_message(data)
        except FusionError as error:
            self._node.fail(error)
        self.work.add(time.perf_counter() - start)

    def _on_probe(self) -> None:
        held = self._backlog.answered()
        if held is not None:
            self._handle(held)

    def _on_lost(self, event: Any) -> None:
        self._gaps.report(event.total_count)

    def _on_incompatible_qos(self, event: Any) -> None:
        log_unfit_publisher(self._node, self.topic, self.profile, event)
