# SPDX-License-Identifier: Apache-2.0
"""Publishers that come, go, offer something else, or are too fast."""

from __future__ import annotations

import math
from pathlib import Path

from nodes.watching import WARN, Diagnostics, Log
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.ros.qos import ESTIMATE, describe
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.feed import START_NS

BEST_EFFORT = QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)


def test_a_mismatch_is_logged_with_both_profiles(harness: Harness, log: Log) -> None:
    harness.fusion_node()
    harness.publisher("/s1", qos=BEST_EFFORT)
    line = log.wait_for("/s1: incompatible QoS")
    assert line.startswith("/s1: incompatible QoS (RELIABILITY), no messages will be received: ")
    assert "requested (reliable, volatile)" in line
    assert "offered by /harness (best effort, volatile)" in line


def test_a_subscription_that_asks_for_too_much_is_logged_with_both_profiles(
    harness: Harness, log: Log
) -> None:
    harness.fusion_node()
    kept = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    harness.record("/fusion_node/weight", qos=kept)
    line = log.wait_for(
        "/fusion_node/weight: incompatible QoS (DURABILITY), no messages will be sent"
    )
    assert "offered (reliable, volatile)" in line
    assert "requested by /harness (reliable, transient local)" in line


def test_qos_overrides_mend_it(harness: Harness) -> None:
    harness.fusion_node(
        {
            "qos_overrides./s1.subscription.reliability": "best_effort",
            "qos_overrides./s2.subscription.reliability": "best_effort",
            "trigger": "pair",
        }
    )
    s1, s2 = (harness.publisher(topic, qos=BEST_EFFORT) for topic in ("/s1", "/s2"))
    estimates = harness.record("/estimate", qos=ESTIMATE)
    harness.spin_until_matched(s1, s2)
    feed = harness.feed()
    for publisher in (s2, s1):
        feed.publish(publisher, Sample(START_NS, 1.0))
    harness.spin_until(lambda: estimates)


def test_an_override_holds_for_its_topic_alone(harness: Harness, tmp_path: Path) -> None:
    deep = {"qos_overrides./fusion_node/weight.publisher.depth": 77}
    node = harness.fusion_node({**deep, "record": str(tmp_path / "bag")})
    depths = {each.topic_name: each.qos_profile.depth for each in node.publishers}
    harness.remove(node)
    with open_bag(tmp_path / "bag") as bag:
        recorded = {name: topic.qos[0].depth for name, topic in bag.topics.items()}
    for found in (depths, recorded):
        assert found["/fusion_node/weight"] == 77
        assert found["/fusion_node/drift"] == 10


def test_deadlines_and_liveliness_are_part_of_a_profile() -> None:
    profile = QoSProfile(
        depth=1, deadline=Duration(seconds=0.5), liveliness=LivelinessPolicy.MANUAL_BY_TOPIC
    )
    text = "reliable, volatile, liveliness manual by topic, deadline 0.5 s"
    assert describe(profile) == text


def test_sensor_data_takes_best_effort_and_reliable_alike(harness: Harness) -> None:
    harness.fusion_node({"qos": "sensor_data", "trigger": "pair"})
    s1 = harness.publisher("/s1", qos=BEST_EFFORT)
    s2 = harness.publisher("/s2")
    estimates = harness.record("/estimate", qos=ESTIMATE)
    harness.spin_until_matched(s1, s2)
    feed = harness.feed()
    for publisher in (s2, s1):
        feed.publish(publisher, Sample(START_NS, 1.0))
    harness.spin_until(lambda: estimates)


def test_a_sensor_driver_that_restarts_is_taken_up_again(harness: Harness) -> None:
    harness.fusion_node({"trigger": "pair"})
    first = harness.feed()
    assert first(0.0, s1=1.0, s2=1.0) == 1.0
    for publisher in (first.s1, first.s2):
        harness.node.destroy_publisher(publisher)
    second = harness.feed()
    assert second(5.0, s1=2.0, s2=2.0) == 2.0


def test_a_late_subscriber_hears_what_comes_from_then_on(harness: Harness) -> None:
    node = harness.fusion_node()
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    late = harness.record("/estimate")
    harness.spin_until(lambda: node.count_subscribers("/estimate") == 2)
    feed(0.01, s1=2.0, s2=2.0)
    harness.spin_until(lambda: late)
    assert [message.header.stamp.nanosec for message in late] == [10_000_000]


def test_a_late_subscriber_that_asks_hears_the_last_estimates_too(harness: Harness) -> None:
    harness.fusion_node()
    feed = harness.feed()
    for k in range(3):
        feed(0.01 * k, s1=1.0, s2=1.0)
    kept = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    late = harness.record("/estimate", qos=kept)
    harness.spin_until(lambda: len(late) == 3)


def test_of_input_faster_than_the_node_the_newest_wins_and_the_rest_is_counted(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"qos": "sensor_data"})
    feed = harness.feed()
    feed(0.0, s1=0.0, s2=0.0)
    burst = 2000
    for k in range(1, burst + 1):  # nothing spins meanwhile: the node is busy
        feed.send(1e-3 * k, s1=math.sin(k))
    newest = START_NS + burst * 1_000_000
    harness.spin_until(lambda: feed.estimates[-1].stamp_ns == newest, "the newest")
    taken = len(feed.estimates) - 1
    assert taken <= 5  # the depth of sensor_data bounds what is kept
    status = diagnostics.saying("fusion_node: s1", f"{burst - taken} lost: queue overflow or")
    assert status.level == WARN
    assert status.values["received"] == str(taken + 1)


def test_reliable_input_is_bounded_too(harness: Harness) -> None:
    harness.fusion_node()
    feed = harness.feed()
    feed(0.0, s1=0.0, s2=0.0)
    for k in range(1, 2001):
        feed.send(1e-3 * k, s1=0.0)
    newest = START_NS + 2000 * 1_000_000
    harness.spin_until(lambda: feed.estimates[-1].stamp_ns == newest, "the newest")
    assert len(feed.estimates) - 1 <= 100


def test_losses_are_not_made_up_where_two_publish_or_one_starts_anew(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair"})
    one, other = harness.feed(), harness.feed()
    for k in range(20):
        feed = (one, one, one, other)[k % 4]
        feed(0.01 * k, s1=0.0, s2=0.0)
    harness.node.destroy_publisher(one.s1)
    third = harness.feed()
    third(1.0, s1=0.0, s2=0.0)
    values = diagnostics.next("fusion_node: s1").values
    assert [count for name, count in values.items() if name.startswith("lost")] == ["0"]
