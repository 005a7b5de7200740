# SPDX-License-Identifier: Apache-2.0
"""A consumer of the estimate that never takes any: nobody else notices."""

from __future__ import annotations

from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile

from faults.fusing import run
from faults.meeting import meet
from faults.streams import S1, clean_stream
from faults.usage import Watch
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.feed import START_NS


def test_a_consumer_that_sleeps_holds_nobody_up() -> None:
    """Its subscription is reliable and deep, and in no executor."""
    stream = clean_stream(600)
    expected = {each.stamp_ns: each.estimate.value for each in run(Parameters(), stream).estimates}
    with Harness() as harness:
        node = harness.start("fusion_node", "--ros-args", "-p", "qos:=reliable")
        feed = harness.feed()
        sleeper = Node("sleeper", context=harness.context)
        try:
            deep = QoSProfile(depth=10_000)
            held = sleeper.create_subscription(PointStamped, "/estimate", print, deep)
            harness.spin_until(lambda: held.get_publisher_count() > 0, "the sleeper matched")
            meet(harness, feed)
            watch = Watch(node.pid)
            for sensor, sample, _ in stream:
                if sensor != S1:  # the same stamp as S1's, which comes next
                    s2 = sample.value
                    continue
                at = (sample.stamp_ns - START_NS) * 1e-9
                assert feed(at, s1=sample.value, s2=s2) == expected[sample.stamp_ns]
                watch.look()
        finally:
            sleeper.destroy_node()
    assert watch.late_growth < 8.0
    assert watch.more_descriptors == 0
