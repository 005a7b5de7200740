# SPDX-License-Identifier: Apache-2.0
"""Quality of service: the profiles of our topics, and the warnings for incompatible peers."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable, Iterator
from typing import Any

from rclpy.exceptions import ParameterException
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_policy_name_from_kind,
)
from rclpy.qos_overriding_options import QoSOverridingOptions

from fuzzy_fusion_ros.parameters.errors import ParameterError

OUTPUT = QoSProfile(depth=10)
"""For all publishers: reliable, which best-effort subscriptions accept too."""

ESTIMATE = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""For the estimate: late joiners that request it get the last messages published before."""

OVERRIDABLE = QoSOverridingOptions.with_default_policies()


def input_profile(name: str) -> QoSProfile:
    """Return the profile of an input: ``sensor_data`` takes the newest, ``reliable`` takes all.

    The depth bounds memory either way; the oldest go first.
    """
    if name == "reliable":
        return QoSProfile(depth=100, reliability=ReliabilityPolicy.RELIABLE)
    return QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


@contextlib.contextmanager
def overridable(topic: str) -> Iterator[None]:
    """Create a publisher or subscription in it: a wrong ``qos_overrides`` is a parameter error.

    Raises:
        ParameterError: The override is of the wrong type, or no value of its policy.
    """
    try:
        yield
    except (ParameterException, RuntimeError) as error:
        if "QoS override" not in str(error) and not isinstance(error, ParameterException):
            raise
        raise ParameterError(f"qos_overrides of {topic}", str(error)) from None


def describe(profile: QoSProfile) -> str:
    """Return the policies that decide whether two ends match."""
    text = f"{_words(profile.reliability)}, {_words(profile.durability)}"
    if profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC:
        text += ", liveliness manual by topic"
    seconds = profile.deadline.nanoseconds * 1e-9
    return f"{text}, deadline {seconds:g} s" if 0.0 < seconds < 1e9 else text


def log_unfit_publisher(node: Node, topic: str, own: QoSProfile, event: Any) -> None:
    """Log that a publisher's profile is incompatible with our subscription, with both profiles."""
    node.get_logger().warning(
        f"{topic}: incompatible QoS ({_policy(event)}), no messages will be received: requested "
        f"({describe(own)}), offered by {_profiles(node.get_publishers_info_by_topic(topic))}"
    )


def log_unfit_subscription(node: Node, topic: str, own: QoSProfile, event: Any) -> None:
    """Log that a subscription's profile is incompatible with our publisher, with both profiles."""
    node.get_logger().warning(
        f"{topic}: incompatible QoS ({_policy(event)}), no messages will be sent: offered "
        f"({describe(own)}), requested by {_profiles(node.get_subscriptions_info_by_topic(topic))}"
    )


def _policy(event: Any) -> str:
    return str(qos_policy_name_from_kind(event.last_policy_kind))


def _profiles(ends: Iterable[Any]) -> str:
    """Return whose profiles they are and what they are."""
    profiles = [
        f"{each.node_namespace.rstrip('/')}/{each.node_name} ({describe(each.qos_profile)})"
        for each in ends
    ]
    return "; ".join(profiles) or "none: the peer has left"


def _words(policy: Any) -> str:
    return str(policy.name).lower().replace("_", " ")
