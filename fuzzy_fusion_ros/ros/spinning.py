# SPDX-License-Identifier: Apache-2.0
"""Spins one node in its own context."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.impl.logging_severity import LoggingSeverity
from rclpy.logging import set_logger_level
from rclpy.task import Future

from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.ros.node import ConfiguredNode


class ArgumentError(FusionError):
    """ROS does not understand its arguments."""


def executor_for(context: Context) -> Executor:
    """Return the executor that costs least: the one of events, where rclpy has it."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def serve(executor: Executor, seconds: float) -> None:
    """Serve an executor's nodes for a time, in one call: one for each event costs 20 µs of CPU."""
    executor.spin_until_future_complete(Future(), timeout_sec=seconds)


def spin(
    make_node: Callable[..., ConfiguredNode[Any]],
    arguments: Sequence[str],
    stopped: Callable[[], bool],
    poll: float,
) -> None:
    """Spin a node until it has ``finished`` or ``stopped`` says so, then close it.

    Args:
        make_node: The node's class.
        arguments: Arguments of the process, without the program's name.
        stopped: Whether to stop.
        poll: Time between two questions, seconds.

    Raises:
        FusionError: ROS or the node refuse the arguments, or the node gives up.
    """
    context = _context_for(arguments)
    try:
        node = make_node(context=context)
        executor = executor_for(context)
        executor.add_node(node)
        try:
            while not (stopped() or node.finished):
                serve(executor, poll)
            if node.failure is not None:
                raise node.failure
        finally:
            executor.remove_node(node)
            node.destroy_node()
    finally:
        context.try_shutdown()


def _context_for(arguments: Sequence[str]) -> Context:
    """Return a context with the process's arguments; the one line on what is wrong is ours."""
    context = Context()
    set_logger_level("rcl", LoggingSeverity.FATAL)
    try:
        context.init(list(arguments))
    except (
        rclpy_implementation.RCLError,
        rclpy_implementation.RCLInvalidROSArgsError,
        rclpy_implementation.UnknownROSArgsError,
    ) as error:
        raise ArgumentError(f"invalid ROS arguments: {error}") from None
    set_logger_level("rcl", LoggingSeverity.UNSET)
    return context
