# SPDX-License-Identifier: Apache-2.0
"""Parts of nodes on their own, at their edges."""

from __future__ import annotations

import sys

import pytest
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile, ReliabilityPolicy

from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.nodes.pendulum_node import PeerError, PendulumNode
from fuzzy_fusion_ros.ros.qos import input_profile, overridable
from fuzzy_fusion_ros.ros.sequence_gaps import SequenceGapCounter
from fuzzy_fusion_ros.ros.spinning import executor_for
from fuzzy_fusion_ros.ros.subscription import RawSubscription
from fuzzy_fusion_ros.testing import Harness


def test_losses_are_the_gaps_in_one_publishers_numbers() -> None:
    gaps = SequenceGapCounter()
    numbers = (5, 6, 10, 11, 3, 4, None, 9, 12)  # it restarts at 3; one has no number
    for number in numbers:
        gaps.add(gaps.before(number))
    assert gaps.count == 3 + 2
    gaps.report(4)
    assert gaps.count == 3 + 2
    gaps.report(9)
    assert gaps.count == 9


def test_message_info_is_taken_from_either_executor(harness: Harness) -> None:
    heard: list[bytes] = []
    receive = RawSubscription(
        harness.fusion_node(), "s3", POINT, input_profile("reliable"), heard.append
    )
    receive(b"two", {"publication_sequence_number": 7})
    receive((b"one", {"publication_sequence_number": 9}))
    assert (heard, receive.lost) == ([b"two", b"one"], 1)


def test_without_an_events_executor_the_usual_one_serves(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy.experimental.events_executor", None)
    executor = executor_for(harness.context)
    assert isinstance(executor, SingleThreadedExecutor)
    executor.shutdown()


def test_nodes_work_in_the_usual_executor_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "rclpy.experimental.events_executor", None)
    with Harness() as harness:
        harness.fusion_node({"trigger": "pair"})
        run = harness.add(PendulumNode, {"duration": 0.5})
        harness.spin_until(lambda: run.finished)


def test_a_subscriber_that_can_never_match_is_named(harness: Harness) -> None:
    harness.fusion_node()
    harness.record("/s1", qos=QoSProfile(depth=1, deadline=Duration(seconds=1e-3)))
    harness.add(PendulumNode, {"timeout": 1.0})
    with pytest.raises(PeerError, match="1 of 2 subscribers of /s1 within 1 s"):
        harness.spin_until(lambda: False)


def test_an_error_that_is_no_override_passes() -> None:
    with pytest.raises(RuntimeError, match="something else"), overridable("x"):
        raise RuntimeError("something else")


def test_best_effort_peers_are_given_time_to_settle(harness: Harness) -> None:
    harness.fusion_node({"qos": "sensor_data"})
    run = harness.add(PendulumNode, {"duration": 0.2})
    harness.spin_until(lambda: run.finished)
    profiles = harness.node.get_subscriptions_info_by_topic("/s1")
    assert profiles[0].qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
