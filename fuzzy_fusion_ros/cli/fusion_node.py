# SPDX-License-Identifier: Apache-2.0
"""Fuses a fast, inaccurate sensor with an accurate, slow one, online."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli.status import command
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.ros.process import Stop

TOPICS = """\
subscribes:
  s1, s2            the sensors, of any message type (s1.type, s1.field, ...)
publishes:
  estimate          the latest S2 message, with its number and stamp replaced
  ~/weight ~/drift ~/aggregate ~/prediction ~/innovation ~/firing_strengths
  ~/standard_deviation
  ~/explanation     how the estimate came about; published while subscribed
  /diagnostics      mode, rates, dropped samples by reason, anything suspicious
services:
  ~/reset           clear the state
  ~/enable          stop or resume publishing the estimate
  ~/save_parameters write the parameters in use to a new file"""


@command("fusion_node")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until it is asked to stop."""

    with Stop() as stop:  # before the imports that take long
        from fuzzy_fusion_ros.ros.command_line import run_node

        def load() -> type:
            from fuzzy_fusion_ros.nodes.fusion_node import FusionNode

            return FusionNode

        return run_node(stop, command_line(), load, arguments)


def command_line() -> Parser:
    """Return the parser of its arguments."""
    from fuzzy_fusion_ros.parameters.fusion import Parameters
    from fuzzy_fusion_ros.ros.command_line import node_parser

    return node_parser("fusion_node", __doc__, TOPICS, Parameters)
