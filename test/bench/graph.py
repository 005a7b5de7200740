# SPDX-License-Identifier: Apache-2.0
"""A ROS graph of its own to measure in: loopback, and a domain that nobody else uses."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from unittest import mock

from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.node import Node

from fuzzy_fusion_ros.ros.spinning import executor_for
from fuzzy_fusion_ros.testing import claimed_domain

PATIENCE = 60.0
"""Seconds that anything may take."""


class Graph:
    """The measuring end of a graph.

    Attributes:
        context: The ROS context.
        node: The node that sends and receives.
        executor: What spins it.
        environment: What child processes need to meet this graph.
    """

    def __init__(self, context: Context, environment: dict[str, str]) -> None:
        self.context = context
        self.environment = environment
        self.node = Node("meter", context=context)
        self.executor: Executor = executor_for(context)
        self.executor.add_node(self.node)

    def spin_to(self, moment: float) -> None:
        """Serve the node until a moment on the steady clock."""
        while (left := moment - time.monotonic()) > 0.0:
            self.executor.spin_once(timeout_sec=left)

    def spin_until(self, predicate: Callable[[], object], patience: float = PATIENCE) -> bool:
        """Serve the node until something is so; return whether it is."""
        deadline = time.monotonic() + patience
        while not predicate():
            if time.monotonic() > deadline:
                return False
            self.executor.spin_once(timeout_sec=0.05)
        return True


@contextlib.contextmanager
def graph() -> Iterator[Graph]:
    """Open a graph."""
    with claimed_domain() as domain, tempfile.TemporaryDirectory() as logs:
        environment = {
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
            "ROS_DOMAIN_ID": str(domain),
            "ROS_LOG_DIR": logs,
        }
        with mock.patch.dict(os.environ, environment):
            context = Context()
            context.init([], domain_id=domain)
            opened = Graph(context, environment)
            try:
                yield opened
            finally:
                opened.executor.remove_node(opened.node)
                opened.node.destroy_node()
                context.try_shutdown()
