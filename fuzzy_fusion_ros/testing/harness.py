"""A ROS graph of its own: context, domain, executor, nodes, recordings and child processes."""

from __future__ import annotations

import contextlib
import os
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, TypeVar

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.publisher import Publisher
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.spinning import executor_for
from fuzzy_fusion_ros.testing.domain import claimed_domain
from fuzzy_fusion_ros.testing.feed import Feed
from fuzzy_fusion_ros.testing.process import Process

N = TypeVar("N", bound=ConfiguredNode[Any])

TIMEOUT = 60.0
"""Seconds that anything may take: much more than it does, as machines can be busy."""

EVERY_MESSAGE = QoSProfile(depth=10_000)
"""Reliable, and deep enough to lose nothing."""


class Harness:
    """A graph for one test; a context manager.

    Attributes:
        context: The ROS context.
        node: A node of the harness's own, to publish, subscribe and call with.
        domain_id: The DDS domain.
        environment: What child processes need to meet this graph.
    """

    def __init__(self) -> None:
        self._closing = contextlib.ExitStack()
        self._nodes: list[ConfiguredNode[Any]] = []

    def __enter__(self) -> Harness:
        """Open the graph."""
        with contextlib.ExitStack() as opening:
            self.domain_id = opening.enter_context(claimed_domain())
            logs = opening.enter_context(tempfile.TemporaryDirectory())
            self.environment = {
                "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
                "ROS_DOMAIN_ID": str(self.domain_id),
                "ROS_LOG_DIR": logs,
            }
            opening.enter_context(_environment(self.environment))
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
        """Close nodes, end child processes, close the graph."""
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
            parameters: Values by their dotted names, on top of those of the file.
            parameter_file: A ROS parameter YAML.
            arguments: ROS arguments, such as ``("-r", "s1:=/imu")``.
            options: As :class:`rclpy.node.Node` takes them.

        Raises:
            FusionError: The node refuses what it is given.
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
        self.spin_until(lambda: node.spinning, f"{node.get_name()} in the executor")
        return node

    def fusion_node(
        self, parameters: Mapping[str, Any] | None = None, **options: Any
    ) -> FusionNode:
        """Run a fusion node; as :meth:`add`, but its inputs are reliable unless said otherwise."""
        return self.add(FusionNode, {"qos": "reliable", **(parameters or {})}, **options)

    def remove(self, node: ConfiguredNode[Any]) -> None:
        """Close a node before the graph, and wait until its name is free again."""
        name = node.get_fully_qualified_name()
        names = self.node.get_fully_qualified_node_names
        before = names().count(name)
        self._nodes.remove(node)
        self._close_node(node)
        self.spin_until(lambda: names().count(name) < before, f"{name} gone")

    def feed(self, **options: Any) -> Feed:
        """Return a feed of both sensors; ``options`` as :class:`Feed` takes them."""
        return Feed(self, **options)

    def publisher(
        self, topic: str, type_name: str = POINT, qos: QoSProfile = EVERY_MESSAGE
    ) -> Publisher:
        """Return a publisher whose subscriptions are matched, if there are any yet."""
        return self.node.create_publisher(load_message_class(type_name), topic, qos)

    def record(
        self, topic: str, type_name: str = POINT, qos: QoSProfile = EVERY_MESSAGE
    ) -> list[Any]:
        """Return a list that messages of a topic are appended to as they come."""
        messages: list[Any] = []
        self.node.create_subscription(load_message_class(type_name), topic, messages.append, qos)
        return messages

    def start(self, executable: str, *arguments: str) -> Process:
        """Run an executable of this package as a child process in this graph."""
        return self._closing.enter_context(
            Process(executable, *arguments, environment=self.environment)
        )

    def spin_until(
        self, predicate: Callable[[], Any], what: str = "", timeout: float = TIMEOUT
    ) -> None:
        """Run the nodes until something is so.

        Args:
            predicate: Whether it is.
            what: It, in words for the error.
            timeout: Longest time to wait, seconds.

        Raises:
            TimeoutError: It is still not so.
            FusionError: A node has given up.
        """
        deadline = time.monotonic() + timeout
        while not predicate():
            left = deadline - time.monotonic()
            if left <= 0.0:
                raise TimeoutError(f"{what or 'what was waited for'} is not so after {timeout} s")
            self._executor.spin_once(timeout_sec=min(left, 0.1))
            for node in self._nodes:
                if node.failure is not None:
                    raise node.failure

    def spin_until_matched(self, *publishers: Publisher) -> None:
        """Run the nodes until both ends of every connection of some publishers are known."""
        self.spin_until(
            lambda: all(self._matched(each) for each in publishers),
            f"a subscription of each of {', '.join(each.topic_name for each in publishers)}",
        )

    def call(self, service_type: Any, name: str, request: Any) -> Any:
        """Call a service and return its response."""
        client = self.node.create_client(service_type, name)
        self.spin_until(client.service_is_ready, f"service {name}")
        future = client.call_async(request)
        self.spin_until(future.done, f"a response of {name}")
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
        """Let go of what it holds of closed nodes, even if a failed test keeps the harness."""
        self._executor.shutdown()
        del self._executor

    def _close_node(self, node: Node) -> None:
        self._executor.remove_node(node)
        node.destroy_node()


@contextlib.contextmanager
def _environment(values: Mapping[str, str]) -> Iterator[None]:
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
