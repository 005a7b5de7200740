# SPDX-License-Identifier: Apache-2.0
"""Simulates an inverted pendulum with two sensors and balances it on their fused estimate."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli.status import command
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.ros.process import Stop

TOPICS = """\
publishes:
  s1, s2                  the angle as the sensors measure it, rad
  truth                   the angle, rad
  control                 the force on the cart, N
  joint_states            the pole, for visualisation
  /clock                  if publish_clock is set
subscribes:
  estimate                what the controller acts on"""


@command("pendulum_node")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until the end of the run, or until it is asked to stop."""

    with Stop() as stop:  # before the imports that take long
        from fuzzy_fusion_ros.ros.command_line import run_node

        def load() -> type:
            from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode

            return PendulumNode

        return run_node(stop, command_line(), load, arguments)


def command_line() -> Parser:
    """Return the parser of its arguments."""
    from fuzzy_fusion_ros.nodes.parameters import PendulumParameters
    from fuzzy_fusion_ros.ros.command_line import node_parser

    return node_parser("pendulum_node", __doc__, TOPICS, PendulumParameters)
