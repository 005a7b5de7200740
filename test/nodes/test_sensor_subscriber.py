# SPDX-License-Identifier: Apache-2.0
"""sensor_subscriber: any type in, a stamped scalar out."""

from __future__ import annotations

import math

from nodes.watching import OK, WARN, Diagnostics, Log

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.nodes.sensor_subscriber import SensorSubscriber
from fuzzy_fusion_ros.online.timeline import LATE_EVIDENCE
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.feed import START_NS

IMU = "sensor_msgs/msg/Imu"


def imu(stamp_ns: int, value: float) -> object:
    message = load_message_class(IMU)()
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    message.header.frame_id = "imu_link"
    message.angular_velocity.y = value
    return message


PARAMETERS = {"input.type": IMU, "input.field": "angular_velocity.y", "qos": "reliable"}


def test_the_number_comes_out_stamped_and_framed_as_it_came_in(harness: Harness) -> None:
    arguments = ("-r", "input:=/imu", "-r", "output:=/s1")
    harness.add(SensorSubscriber, PARAMETERS, arguments=arguments)
    publisher = harness.publisher("/imu", IMU)
    out = harness.record("/s1")
    harness.spin_until_matched(publisher)
    harness.spin_until(lambda: harness.node.count_publishers("/s1"))
    publisher.publish(imu(5 * 10**9 + 7, 1.25))
    harness.spin_until(lambda: out)
    stamp = out[0].header.stamp
    assert (stamp.sec, stamp.nanosec) == (5, 7)
    assert out[0].header.frame_id == "imu_link"
    assert (out[0].point.x, out[0].point.y, out[0].point.z) == (1.25, 0.0, 0.0)


def test_what_cannot_be_used_is_dropped_and_said(
    harness: Harness, diagnostics: Diagnostics, log: Log
) -> None:
    harness.add(SensorSubscriber, PARAMETERS)
    publisher = harness.publisher("/input", IMU)
    out = harness.record("/output")
    harness.spin_until_matched(publisher)
    bad = [Sample(START_NS, math.nan), Sample(0, 1.0), Sample((2**31 - 1) * 10**9, 1.0)]
    good = [Sample(START_NS, 1.0), Sample(START_NS + 10, 2.0)]
    late = [Sample(START_NS + 5, 3.0), Sample(START_NS + 20, 4.0)]
    for stamp_ns, value, _ in (*bad, *good, *late):
        publisher.publish(imu(stamp_ns, value))
    harness.spin_until(lambda: len(out) == 3)
    status = diagnostics.saying("sensor_subscriber: input", "dropped")
    assert status.level == WARN
    assert [message.point.x for message in out] == [1.0, 2.0, 4.0]
    counts = {name: n for name, n in status.values.items() if name.startswith("dropped")}
    assert list(counts.values()) == ["1", "1", "0", "0", "1", "1", "0", "0", "0"]
    for k in range(LATE_EVIDENCE):
        publisher.publish(imu(START_NS // 2 + k, 5.0))
    harness.spin_until(lambda: len(out) == 3 + LATE_EVIDENCE)
    log.wait_for("timestamps jumped back: passing on the new ones")


def test_it_feeds_a_fusion_node(harness: Harness, diagnostics: Diagnostics) -> None:
    patient = {**PARAMETERS, "input.timeout": 1000.0}
    harness.add(SensorSubscriber, patient, arguments=("-r", "output:=s1"))
    harness.fusion_node({"trigger": "pair"})
    publisher = harness.publisher("/input", IMU)
    harness.spin_until_matched(publisher)
    feed = harness.feed()
    harness.node.destroy_publisher(feed.s1)
    harness.spin_until(lambda: harness.node.count_publishers("/s1") == 1)
    publisher.publish(imu(START_NS, 3.0))
    feed.send(0.0, s2=3.0)
    harness.spin_until(lambda: feed.estimates)
    assert feed.estimates == [Sample(START_NS, 3.0)]
    assert diagnostics.next("sensor_subscriber: input").level == OK
