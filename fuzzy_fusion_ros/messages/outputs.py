"""The messages that come out: the estimate, and what stands behind it.

They are built of whatever messages ``new`` makes, rclpy's or rosbags', so that a node and a
replay give the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.fusion import Fused
from fuzzy_fusion_ros.core.parameters import EstimateParameters
from fuzzy_fusion_ros.messages.field_path import FieldPath
from fuzzy_fusion_ros.messages.resolve import resolve_field
from fuzzy_fusion_ros.messages.sample import SECOND_NS, copy_with
from fuzzy_fusion_ros.messages.type_fields import TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import normalise_type_name

New = Callable[[str], Any]
"""Makes a message of a type, ``package/msg/Type``; its fields need not be blank."""

POINT = "geometry_msgs/msg/PointStamped"
ARRAY = "std_msgs/msg/Float64MultiArray"
DIMENSION = "std_msgs/msg/MultiArrayDimension"

STRENGTHS = "firing_strengths"
EXPLANATION = {
    **dict.fromkeys(("weight", "drift", "aggregate", "prediction", "innovation"), POINT),
    STRENGTHS: ARRAY,
}
"""The topics below the node's own name, and their types."""


def explain(new: New, fused: Fused) -> Iterator[tuple[str, Any]]:
    """Yield what stands behind an estimate: topic and message, one by one.

    Args:
        new: Makes the messages; it may give those of an earlier estimate again, and one
            stamped scalar for all.
        fused: The estimate. Without a prediction its two topics are silent.
    """
    for name, value in scalars(fused.estimate).items():
        yield name, point(new, fused.stamp_ns, value)
    yield STRENGTHS, strengths_message(new, fused.estimate.aggregate.strengths)


def scalars(estimate: Estimate) -> dict[str, float]:
    """Return the numbers behind an estimate by their topics' names."""
    aggregate, prediction = estimate.aggregate, estimate.prediction
    known = {"weight": aggregate.weight, "drift": aggregate.drift, "aggregate": aggregate.value}
    if prediction.exists:
        known["prediction"] = prediction.value
        known["innovation"] = aggregate.value - prediction.value
    return known


def point(new: New, stamp_ns: int, value: float, frame: str = "") -> Any:
    """Return a stamped scalar, in ``point.x``."""
    message = new(POINT)
    message.header.frame_id = frame
    stamp = message.header.stamp
    stamp.sec, stamp.nanosec = divmod(stamp_ns, SECOND_NS)
    message.point.x = value
    return message


def strengths_message(new: New, strengths: FiringStrengths) -> Any:
    """Return the firing strengths in Table 1's order: by difference, then by rate."""
    message = new(ARRAY)
    values = list(strengths)
    message.data = np.array(values) if isinstance(message.data, np.ndarray) else values
    message.layout.dim = [
        _dimension(new(DIMENSION), "difference: small, large", 4),
        _dimension(new(DIMENSION), "rate: small, large", 2),
    ]
    return message


def _dimension(message: Any, label: str, stride: int) -> Any:
    message.label = label
    message.size = 2
    message.stride = stride
    return message


class EstimateMessages:
    """Makes messages of estimates: S2's latest with another number and stamp, or a type of its own.

    Attributes:
        type_name: Their type.
        field: Where the estimate is in them.
    """

    def __init__(
        self,
        types: TypeDescriptions,
        new: New,
        parameters: EstimateParameters,
        s2_type: str,
        s2_field: FieldPath,
    ) -> None:
        """Settle type and field.

        Args:
            types: Who describes message types.
            new: Makes the message to copy from until S2 has come.
            parameters: Type and field where they are not S2's.
            s2_type: The type of S2.
            s2_field: Where S2's number is.

        Raises:
            MessageError: The type is unknown or has no such field.
        """
        self._copies_s2 = parameters.type == "" or normalise_type_name(parameters.type) == s2_type
        self.type_name = s2_type if self._copies_s2 else normalise_type_name(parameters.type)
        if self._copies_s2 and not parameters.field:
            self.field = s2_field
        else:
            self.field = resolve_field(types, self.type_name, parameters.field)
        self._template = new(self.type_name)

    def see_s2(self, message: Any) -> None:
        """Take a message of S2 as the one to copy from now on."""
        if self._copies_s2:
            self._template = message
        elif hasattr(self._template, "header") and hasattr(message, "header"):
            self._template.header.frame_id = message.header.frame_id

    def message(self, fused: Fused) -> Any:
        """Return the message of an estimate.

        Raises:
            MessageError: The number or the stamp does not fit into it.
        """
        return copy_with(self._template, self.field, fused.estimate.value, fused.stamp_ns)
