# SPDX-License-Identifier: Apache-2.0
"""The bare relay: subscribes, publishes, nothing else. What any node in Python must pay.

    python -m bench.relay EXECUTOR PROFILE [ROS arguments]

It takes ``s1`` and ``s2`` as fusion_node does and gives each message of S1 out as ``estimate``; on
the executor ``raw`` as the bytes that came, of which it makes no message.
"""

from __future__ import annotations

import sys

from geometry_msgs.msg import PointStamped
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node

from fuzzy_fusion_ros.ros.process import POLL, Stop
from fuzzy_fusion_ros.ros.qos import ESTIMATE, input_profile
from fuzzy_fusion_ros.ros.spinning import executor_for, serve

DEFAULT, EVENTS, RAW = "default", "events", "raw"
"""rclpy's own executor, the one that fusion_node runs on, and that one with bytes for messages."""


def main() -> None:
    """Relay until told to stop; whoever leaves without a word counts as there for 20 s."""
    with Stop() as stop:
        _relay(stop, *sys.argv[1:])


def _relay(stop: Stop, kind: str, profile: str, *arguments: str) -> None:
    context = Context()
    context.init(list(arguments))
    stop.in_order()
    node = Node("relay", context=context)
    publisher = node.create_publisher(PointStamped, "estimate", ESTIMATE)
    raw, qos = kind == RAW, input_profile(profile)
    node.create_subscription(PointStamped, "s1", publisher.publish, qos, raw=raw)
    node.create_subscription(PointStamped, "s2", lambda message: None, qos, raw=raw)
    executor: Executor = SingleThreadedExecutor(context=context)
    if kind in {EVENTS, RAW}:
        executor = executor_for(context)
    executor.add_node(node)
    while not stop.wanted:
        serve(executor, POLL)
    executor.remove_node(node)
    node.destroy_node()
    context.try_shutdown()


if __name__ == "__main__":
    main()
