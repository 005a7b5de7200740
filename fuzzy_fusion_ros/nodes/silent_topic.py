# SPDX-License-Identifier: Apache-2.0
"""Why a topic may be silent: what else is in the graph."""

from __future__ import annotations

import difflib
from collections.abc import Iterator

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy

from fuzzy_fusion_ros.ros.subscription import RawSubscription

MOST_SIMILAR = 3
"""Most topics that are named."""


def reasons(node: Node, subscription: RawSubscription) -> Iterator[str]:
    """Yield what may keep messages from coming.

    Args:
        node: The node that subscribes.
        subscription: The subscription, on which nothing has been received.
    """
    topic, own_type = subscription.topic, subscription.type_name
    publishers = subscription.publishers()
    for other in sorted({each.topic_type for each in publishers} - {own_type}):
        yield f"published as {other}, subscribed as {own_type}"
    if any(
        each.topic_type == own_type
        and each.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL
        for each in publishers
    ):
        yield (
            "its publisher offers TRANSIENT_LOCAL, but messages from before this node started are "
            f"only received with qos_overrides.{topic}.subscription.durability: transient_local"
        )
    similar = [] if publishers else similar_topics(node, topic, own_type)
    if similar:
        yield f"it has no publisher; similar topics: {', '.join(similar)}"


def similar_topics(node: Node, topic: str, type_name: str) -> list[str]:
    """Return topics that others publish, of a like name first, then of the same type."""
    own = {topic, *(publisher.topic_name for publisher in node.publishers)}
    types = {
        name: found
        for name, found in node.get_topic_names_and_types()
        if name not in own and node.count_publishers(name)
    }
    like = difflib.get_close_matches(topic, types, n=MOST_SIMILAR, cutoff=0.7)
    same = sorted(name for name, found in types.items() if type_name in found)
    chosen = list(dict.fromkeys([*like, *same]))[:MOST_SIMILAR]
    return [f"{name} ({', '.join(types[name])})" for name in chosen]
