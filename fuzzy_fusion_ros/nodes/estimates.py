"""The estimate as a message: S2's latest with another number and stamp, or a type of its own."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.core.fusion import Fused
from fuzzy_fusion_ros.core.parameters import EstimateParameters
from fuzzy_fusion_ros.messages import (
    InstalledTypes,
    copy_with,
    load_message_class,
    normalise_type_name,
    resolve_field,
)
from fuzzy_fusion_ros.nodes.outlet import Outlet
from fuzzy_fusion_ros.nodes.recorder import Recorder
from fuzzy_fusion_ros.nodes.sensor_input import SensorInput


class EstimateOutput:
    """Publishes estimates.

    Attributes:
        published: Estimates published.
        unwritable: Estimates that did not fit into a message.
        last_problem: Why the last of them did not; empty if none was.
    """

    def __init__(
        self, node: Node, parameters: EstimateParameters, s2: SensorInput, recorder: Recorder
    ) -> None:
        """Publish on ``estimate``.

        Raises:
            MessageError: The type is not installed or has no such field.
        """
        like_s2 = parameters.type in ("", s2.type_name)
        type_name = s2.type_name if like_s2 else normalise_type_name(parameters.type)
        if like_s2 and not parameters.field:
            self._field = s2.field
        else:
            self._field = resolve_field(InstalledTypes(), type_name, parameters.field)
        self._copies_s2 = like_s2
        self._template = load_message_class(type_name)()
        self._outlet = Outlet(node, "estimate", type_name, recorder)
        self.published = 0
        self.unwritable = 0
        self.last_problem = ""

    def see_s2(self, message: Any) -> None:
        """Take a message of S2 as the one to copy from now on."""
        if self._copies_s2:
            self._template = message
        elif hasattr(self._template, "header") and hasattr(message, "header"):
            self._template.header.frame_id = message.header.frame_id

    def publish(self, fused: Fused, log_ns: int) -> bool:
        """Publish an estimate; return whether it fitted into a message."""
        try:
            message = copy_with(self._template, self._field, fused.estimate.value, fused.stamp_ns)
        except MessageError as error:
            self.unwritable += 1
            self.last_problem = str(error)
            return False
        self._outlet.send(message, log_ns)
        self.published += 1
        return True
