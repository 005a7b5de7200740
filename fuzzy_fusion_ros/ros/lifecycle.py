# SPDX-License-Identifier: Apache-2.0
"""The states of a managed node, https://design.ros2.org/articles/node_lifecycle.html."""

from __future__ import annotations

from typing import Any, Protocol

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNodeMixin, LifecycleState, TransitionCallbackReturn
from rclpy.node import Node

from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.ros.node import ConfiguredNode

ENTITIES = ("publisher", "subscription", "service", "timer")


class Managed(Protocol):
    """What a node that is managed can do."""

    def connect(self) -> None:
        """Create topics, services and timers; publish nothing.

        Raises:
            FusionError: A parameter, a message type, a field or a bag cannot be used.
        """

    def disconnect(self) -> None:
        """Let go of what is no entity of the node: bags and callbacks of clocks."""

    def activate(self, active: bool) -> None:
        """Publish from now on, or no longer."""


class Lifecycle(LifecycleNodeMixin, Node):
    """Offers the services of a managed node and carries out the transitions.

    It is a second class over the state of one node, instead of a base class of it: whether a node
    is managed is a parameter, and importing rclpy's base class costs every start 0.1 s.
    """

    def __init__(self, node: ConfiguredNode[Any], managed: Managed) -> None:
        """Offer the services; the state is *unconfigured*.

        Args:
            node: The node.
            managed: The same node, as what it can do.
        """
        self.__dict__ = node.__dict__
        LifecycleNodeMixin.__init__(self)
        self._change = self._service_change_state.callback
        self._service_change_state.callback = self._on_change
        self._managed = managed
        self._kept = _entities(self)

    def close(self) -> None:
        """Let go of the states, which rclpy leaves to the garbage collector: they hold the node."""
        self._state_machine.destroy_when_not_in_use()

    def _on_change(self, request: Any, response: Any) -> Any:
        """Refuse a transition that the state does not have; rclpy would end the process."""
        try:
            return self._change(request, response)
        except rclpy_implementation.RCLError:
            response.success = False
            return response

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Create what the node is made of, or stay unconfigured and log why."""
        try:
            self._managed.connect()
        except FusionError as error:
            Node.get_logger(self).error(f"not configured: {error}")
            self._clean_up()
            return TransitionCallbackReturn.FAILURE
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Publish."""
        self._managed.activate(True)
        return TransitionCallbackReturn.SUCCESS

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Process samples, but publish nothing."""
        self._managed.activate(False)
        return TransitionCallbackReturn.SUCCESS

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Remove what the node is made of, and with it its state."""
        self._clean_up()
        return TransitionCallbackReturn.SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Clean up for good; the process runs until it is asked to stop."""
        self._clean_up()
        return TransitionCallbackReturn.SUCCESS

    def _clean_up(self) -> None:
        self._managed.disconnect()
        for timer in _entities(self)["timer"] - self._kept["timer"]:
            timer.cancel()  # the executor may have queued it, and still calls it otherwise
        for kind, entities in _entities(self).items():
            for entity in entities - self._kept[kind]:
                getattr(self, f"destroy_{kind}")(entity)


def _entities(node: Node) -> dict[str, set[Any]]:
    return {kind: set(getattr(node, f"{kind}s")) for kind in ENTITIES}
