# SPDX-License-Identifier: Apache-2.0
"""What the node says so that a user need not guess: at the start, of silence, of the first drop."""

from __future__ import annotations

import pytest
from nodes.watching import OK, WARN, Diagnostics, Log
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.nodes import sensor_report
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.feed import START_NS

SECOND = 10**9


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let silence be said at once."""
    monkeypatch.setattr(sensor_report, "SILENT", 0.0)


def test_one_line_says_what_is_fused_into_what(harness: Harness, log: Log) -> None:
    harness.fusion_node(
        {"s1.type": "sensor_msgs/msg/Imu", "s1.field": "linear_acceleration.x"},
        arguments=("-r", "s1:=/imu", "-r", "__ns:=/robot"),
    )
    assert log.wait_for("trigger: s1") == (
        "s1: /imu, linear_acceleration.x of sensor_msgs/msg/Imu in m/s^2; "
        f"s2: /robot/s2, point.x of {POINT}; estimate: /robot/estimate, point.x of {POINT}; "
        "trigger: s1"
    )
    log.wait_for("WAITING: waiting for both sensors")


@pytest.mark.usefixtures("impatient")
def test_a_silent_topic_is_named_with_those_of_a_like_name_or_type(
    harness: Harness, log: Log
) -> None:
    harness.publisher("/s_1", "std_msgs/msg/Float64")
    harness.publisher("/gps/odometry", POINT)
    harness.publisher("/unlike/both", "std_msgs/msg/String")
    harness.spin_until(lambda: harness.node.count_publishers("/gps/odometry"))
    harness.fusion_node()
    said = log.wait_for("/s1: no message received for 0 s; it has no publisher; similar topics:")
    assert "/s_1 (std_msgs/msg/Float64)" in said
    assert f"/gps/odometry ({POINT})" in said
    assert "/unlike/both" not in said


@pytest.mark.usefixtures("impatient")
def test_a_latched_publisher_from_before_is_explained(harness: Harness, log: Log) -> None:
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    harness.node.create_publisher(harness_type(), "/s2", latched)
    harness.fusion_node()
    log.wait_for("qos_overrides./s2.subscription.durability: transient_local")


def harness_type() -> type:
    """Return the class of the default type."""
    from fuzzy_fusion_ros.messages import load_message_class

    return load_message_class(POINT)


def test_the_first_drop_of_a_kind_is_logged_with_its_reason(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"s1.timeout": 1000.0})
    feed = harness.feed()
    for _ in range(2):
        feed.publish(feed.s1, Sample(0, 1.0))
        diagnostics.saying("fusion_node: s1", "1 dropped: stamp is zero")
    feed.publish(feed.s1, Sample(-1, 1.0))
    log.wait_for("/s1: 1 dropped: stamp is negative")
    assert log.count("/s1: 1 dropped: stamp is zero; from now on counted in /diagnostics") == 1


def test_two_publishers_whose_clocks_are_apart_are_named(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"s1.timeout": 1000.0, "s2.timeout": 1000.0})
    feed = harness.feed()
    other = Node("the_other", context=harness.context)
    second = other.create_publisher(harness_type(), "/s1", 10)
    harness.spin_until_matched(feed.s1)
    harness.spin_until(lambda: second.get_subscription_count() > 0)
    hour = 3600 * SECOND
    for k in range(20):
        feed(7200.0 + 0.01 * k, s1=1.0, s2=1.0)
        feed.publish(second, Sample(START_NS + hour + k, 5.0))
    status = diagnostics.saying("fusion_node: s1", "2 publishers, /harness and /the_other")
    assert status.level == WARN
    log.wait_for("/s1: 2 publishers, /harness and /the_other, whose timestamps interleave")
    stamps = [sample.stamp_ns for sample in feed.estimates]
    assert stamps == sorted(stamps)
    assert {sample.value for sample in feed.estimates} == {1.0}
    assert log.count("timestamps jumped back") == 0
    other.destroy_node()


def test_clocks_that_are_apart_are_said_with_the_offset(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"s1.timeout": 1.0, "s2.timeout": 1.0})
    feed = harness.feed()
    for k in range(20):
        feed.send(100.0 + 0.01 * k, s1=1.0)
        feed.publish(feed.s2, Sample(START_NS + 95 * SECOND + 10_000_000 * k, 1.0))
    text = "s2's stamps are 5.0 s behind s1's"
    assert diagnostics.saying("fusion_node: fusion", text).level == WARN
    log.wait_for(text)
    diagnostics.next("fusion_node: fusion")
    assert log.count(text) == 1


def test_a_clock_that_nobody_publishes_is_said(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"use_sim_time": True})
    log.wait_for("use_sim_time is true, but nothing has been received on /clock")


def test_a_node_in_order_warns_of_nothing(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"s1.timeout": 1000.0, "s2.timeout": 1000.0})
    feed = harness.feed()
    for k in range(50):
        feed(0.01 * k, s1=1.0, s2=1.0)
    for part in ("fusion", "s1", "s2"):
        assert diagnostics.next(f"fusion_node: {part}").level == OK
    assert log.lines[-1].startswith("FUSED")


def test_weights_out_of_order_are_accepted_with_a_warning(harness: Harness, log: Log) -> None:
    harness.fusion_node({"aggregator.weight.very_small": 0.9})
    assert "got 0.9, 0.016, 0.12, 0.42" in log.wait_for("aggregator.weight.very_small")
