"""Fuses a fast, noisy sensor with a slow, accurate one, live."""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli.status import command
from fuzzy_fusion_ros.ros.process import Stop

TOPICS = """\
subscribes:
  s1, s2                  the sensors, of any type (s1.type, s1.field, ...)
publishes:
  estimate                the estimate: S2's latest message with its number and stamp replaced
  ~/weight ~/drift ~/aggregate ~/prediction ~/innovation ~/firing_strengths
                          why it is what it is, while subscribed
  /diagnostics            mode, rates, drops with their reasons, and what looks wrong
services:
  ~/reset, ~/enable"""


@command("fusion_node")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the node until it is told to stop."""

    with Stop() as stop:  # before the imports that take long
        from fuzzy_fusion_ros.parameters.fusion import Parameters
        from fuzzy_fusion_ros.ros.command_line import run_node

        def load() -> type:
            from fuzzy_fusion_ros.nodes.fusion_node import FusionNode

            return FusionNode

        return run_node(stop, "fusion_node", __doc__, TOPICS, Parameters, load, arguments)
