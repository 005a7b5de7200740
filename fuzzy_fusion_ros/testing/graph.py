# SPDX-License-Identifier: Apache-2.0
"""An isolated ROS graph: context, domain, executor, and one node to talk to the others with."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.spinning import executor_for
from fuzzy_fusion_ros.testing.domain import claimed_domain, environment, isolation

S = TypeVar("S", bound="Graph")
N = TypeVar("N", bound=ConfiguredNode[Any])

TIMEOUT = 60.0
"""Seconds to wait for anything: far longer than it takes, because machines can be busy."""

EVERY_MESSAGE = QoSProfile(depth=10_000)
"""Reliable, and deep enough to lose nothing."""


class Graph:
    """An isolated ROS graph; a context manager.

    Attributes:
        context: The ROS context.
        node: A node of the graph's own, to publish, subscribe and call services with.
        domain_id: The DDS domain.
        environment: The environment variables with which a child process joins this graph.
    """

    def __init__(self, domain_id: int | None = None) -> None:
        """Prepare the graph.

        Args:
            domain_id: The DDS domain, from ``ros_domain`` or :func:`claimed_domain`; one is claimed
                unless it is given.
        """
        self._given = domain_id
        self._closing = contextlib.ExitStack()
        self._nodes: list[ConfiguredNode[Any]] = []

    def __enter__(self: S) -> S:
        """Open the graph."""
        with contextlib.ExitStack() as opening:
            if self._given is None:
                self.domain_id = opening.enter_context(claimed_domain())
            else:
                self.domain_id = self._given
            logs = opening.enter_context(tempfile.TemporaryDirectory())
            self.environment = {**isolation(self.domain_id), "ROS_LOG_DIR": logs}
            opening.enter_context(environment(self.environment))
            self.context = Context()
            self.context.init([], domain_id=self.domain_id)
            opening.callback(self.context.try_shutdown)
            self._executor = executor_for(self.context)
            opening.callback(self._drop_executor)
            self.node = Node("harness", context=self.context)
            self._executor.add_node(self.node)
            opening.callback(self._close_node, self.node)
            self._closing = opening.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        """Close the nodes, end the child processes and close the graph."""
        self._closing.close()

    def add(
        self,
        node_class: Callable[..., N],
        parameters: Mapping[str, Any] | None = None,
        *,
        parameter_file: str | Path | None = None,
        arguments: tuple[str, ...] = (),
        **options: Any,
    ) -> N:
        """Run a node of this package in this graph, in this process.

        Args:
            node_class: Its class.
            parameters: Values by dotted name; they override those of the file.
            parameter_file: A ROS parameter YAML.
            arguments: ROS arguments, such as ``("-r", "s1:=/imu")``.
            options: Keyword arguments of :class:`rclpy.node.Node`.

        Raises:
            FusionError: The node rejects its parameters or arguments.
        """
        files = [] if parameter_file is None else [str(parameter_file)]
        given = [word for path in files for word in ("--params-file", path)]
        node = node_class(
            context=self.context,
            cli_args=["--ros-args", *given, *arguments],
            parameter_files=files,
            parameter_overrides=[Parameter(k, value=v) for k, v in (parameters or {}).items()],
            **options,
        )
        self._executor.add_node(node)
        self._nodes.append(node)
        self._closing.callback(self._close_node, node)
        self.spin_until(lambda: node.spinning, f"{node.get_name()} to spin")
        return node

    def remove(self, node: ConfiguredNode[Any]) -> None:
        """Close a node early, and wait until its name has left the graph."""
        name = node.get_fully_qualified_name()
        names = self.node.get_fully_qualified_node_names
        self.spin_until(lambda: name in names(), f"{name} to be seen")
        before = names().count(name)
        self._nodes.remove(node)
        self._close_node(node)
        self.spin_until(lambda: names().count(name) < before, f"{name} to leave the graph")

    def publisher(
        self, topic: str, type_name: str = POINT, qos: QoSProfile = EVERY_MESSAGE
    ) -> Publisher:
        """Return a publisher of a topic, reliable unless ``qos`` says otherwise."""
        return self.node.create_publisher(load_message_class(type_name), topic, qos)

    def record(
        self, topic: str, type_name: str = POINT, qos: QoSProfile = EVERY_MESSAGE
    ) -> list[Any]:
        """Subscribe to a topic; return the list to which its messages are appended."""
        messages: list[Any] = []
        self.node.create_subscription(load_message_class(type_name), topic, messages.append, qos)
        return messages

    def spin_until(
        self, predicate: Callable[[], Any], what: str = "", timeout: float = TIMEOUT
    ) -> None:
        """Spin the nodes until a predicate is true.

        Args:
            predicate: The predicate, called between callbacks.
            what: What it waits for, for the error message.
            timeout: Longest time to wait, seconds.

        Raises:
            TimeoutError: The predicate is still false.
            FusionError: A node has failed.
        """
        deadline = time.monotonic() + timeout
        while not predicate():
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise TimeoutError(f"waited {timeout} s for {what or 'a predicate'}")
            self._executor.spin_once(timeout_sec=min(left, 0.1))
            for node in self._nodes:
                if node.failure is not None:
                    raise node.failure

    def spin_until_matched(self, *publishers: Publisher) -> None:
        """Spin the nodes until every publisher has a subscription and both ends know it."""
        self.spin_until(
            lambda: all(self._matched(each) for each in publishers),
            f"subscriptions to {', '.join(each.topic_name for each in publishers)}",
        )

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Call a service and return its response."""
        client = self.node.create_client(service_type, name)
        self.spin_until(client.service_is_ready, f"service {name}")
        future = client.call_async(request)
        self.spin_until(future.done, f"a response from {name}")
        self.node.destroy_client(client)
        return future.result()

    def _matched(self, publisher: Publisher) -> bool:
        ours = [
            each
            for node in (self.node, *self._nodes)
            for each in node.subscriptions
            if each.topic_name == publisher.topic_name
        ]
        known = publisher.get_subscription_count()
        return known >= max(1, len(ours)) and all(each.get_publisher_count() > 0 for each in ours)

    def _drop_executor(self) -> None:
        """Release what the executor holds, even where a failed test keeps the graph alive."""
        self._executor.shutdown()
        del self._executor

    def _close_node(self, node: Node) -> None:
        self._executor.remove_node(node)
        node.destroy_node()
