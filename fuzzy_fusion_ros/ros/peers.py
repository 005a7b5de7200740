# SPDX-License-Identifier: Apache-2.0
"""The other end of the loop: whether it is there, so that no first message is lost."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.subscription import Subscription

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher

SETTLED = 0.5
"""Time for a peer that cannot request missed messages to discover this node, seconds."""


class Source:
    """A topic that is subscribed to once its publishers, and what they offer, are known.

    A publisher can send before it knows a subscription that already knows the publisher. If it
    keeps its last messages for late joiners, as fusion_node does, we ask for them.

    Attributes:
        topic: The full name of the topic.
    """

    def __init__(
        self, node: Node, topic: str, type_name: str, callback: Callable[[bytes], None]
    ) -> None:
        self.topic: str = node.resolve_topic_name(topic)
        self._node = node
        self._type = load_message_class(type_name)
        self._callback = callback
        self._subscription: Subscription | None = None
        self._keeps_last = False

    def look(self) -> None:
        """Subscribe if there is a publisher now."""
        offers = self._node.get_publishers_info_by_topic(self.topic)
        if self._subscription is not None or not offers:
            return
        durabilities = {offer.qos_profile.durability for offer in offers}
        self._keeps_last = durabilities == {DurabilityPolicy.TRANSIENT_LOCAL}
        profile = QoSProfile(
            depth=10,
            durability=DurabilityPolicy.TRANSIENT_LOCAL
            if self._keeps_last
            else DurabilityPolicy.VOLATILE,
        )
        self._subscription = self._node.create_subscription(
            self._type, self.topic, self._callback, profile, raw=True
        )

    @property
    def matched(self) -> bool:
        """Whether a publisher is matched."""
        return self._subscription is not None and self._subscription.get_publisher_count() > 0

    @property
    def keeps_last(self) -> bool:
        """Whether what was published before it knew us comes too."""
        return self._keeps_last


class Peers:
    """Watches the subscribers of some topics and the publishers of another."""

    def __init__(
        self, node: Node, publishers: Sequence[RecordingPublisher], source: Source
    ) -> None:
        self._node = node
        self._publishers = publishers
        self._source = source
        self._matched_since: float | None = None

    def ready(self, now: float) -> bool:
        """Return whether all are matched and, where that takes time, settled.

        Args:
            now: Steady time, seconds.
        """
        self._source.look()
        if self.missing():
            self._matched_since = None
            return False
        if self._matched_since is None:
            self._matched_since = now
        return self._all_sure() or now - self._matched_since >= SETTLED

    def missing(self) -> list[str]:
        """Say what is not there yet, empty if all is."""
        missing = []
        for publisher in self._publishers:
            known = self._node.count_subscribers(publisher.topic)
            if known == 0:
                missing.append(f"nobody subscribes to {publisher.topic}")
            elif publisher.subscribers < known:
                missing.append(
                    f"{publisher.subscribers} of {known} subscribers of {publisher.topic}"
                )
        if not self._source.matched:
            missing.append(f"nobody publishes {self._source.topic}")
        return missing

    def _all_sure(self) -> bool:
        return self._source.keeps_last and all(
            each.qos_profile.reliability == ReliabilityPolicy.RELIABLE
            for publisher in self._publishers
            for each in self._node.get_subscriptions_info_by_topic(publisher.topic)
        )
