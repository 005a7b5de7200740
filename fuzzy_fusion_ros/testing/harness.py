# SPDX-License-Identifier: Apache-2.0
"""Nodes of this package in a ROS graph of their own, in this process or as child processes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.testing.feed import Feed
from fuzzy_fusion_ros.testing.graph import Graph
from fuzzy_fusion_ros.testing.process import Process


class Harness(Graph):
    """A graph for one test, with the nodes under test in it; a context manager."""

    def fusion_node(
        self, parameters: Mapping[str, Any] | None = None, **options: Any
    ) -> FusionNode:
        """Run a fusion node as :meth:`add` does, with reliable inputs unless told otherwise."""
        return self.add(FusionNode, {"qos": "reliable", **(parameters or {})}, **options)

    def feed(self, **options: Any) -> Feed:
        """Return a feed of both sensors; ``options`` as :class:`Feed` takes them."""
        return Feed(self, **options)

    def start(self, executable: str, *arguments: str) -> Process:
        """Run an executable of this package as a child process in this graph."""
        return self._closing.enter_context(
            Process(executable, *arguments, environment=self.environment)
        )
