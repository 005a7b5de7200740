# SPDX-License-Identifier: Apache-2.0
"""Extracts one number from messages of any type, drops invalid ones and republishes the rest."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli.status import command
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.ros.process import Stop

TOPICS = """\
subscribes:
  input             the sensor, of any message type (input.type, input.field)
publishes:
  output            the number as geometry_msgs/msg/PointStamped, in point.x
  /diagnostics      rate, age, dropped samples by reason"""


@command("sensor_subscriber")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until it is asked to stop."""

    with Stop() as stop:  # before the imports that take long
        from fuzzy_fusion_ros.ros.command_line import run_node

        def load() -> type:
            from fuzzy_fusion_ros.nodes.sensor_subscriber import SensorSubscriber

            return SensorSubscriber

        return run_node(stop, command_line(), load, arguments)


def command_line() -> Parser:
    """Return the parser of its arguments."""
    from fuzzy_fusion_ros.nodes.parameters import SubscriberParameters
    from fuzzy_fusion_ros.ros.command_line import node_parser

    return node_parser("sensor_subscriber", __doc__, TOPICS, SubscriberParameters)
