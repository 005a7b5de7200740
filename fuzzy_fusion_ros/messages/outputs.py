# SPDX-License-Identifier: Apache-2.0
"""The messages that come out: the estimate, and what stands behind it, serialised."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.messages.cdr import CdrWriter
from fuzzy_fusion_ros.messages.codec import ScalarCodec, Template
from fuzzy_fusion_ros.messages.defaults import default_message
from fuzzy_fusion_ros.messages.type_fields import TypeDescriptions
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.messages.variances import Elements, variance_of
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import EstimateParameters

TEXT = "std_msgs/msg/String"
POINT = "geometry_msgs/msg/PointStamped"
JOINTS = "sensor_msgs/msg/JointState"
"""The one stock type with a stamp, names and numbers; plotting tools show them by their names."""

RULES = tuple(f"difference_{d}_rate_{r}" for d in ("small", "large") for r in ("small", "large"))
"""Table 1's rules in its order, as they are named beside their firing strengths."""

DEVIATION = "standard_deviation"
STRENGTHS = "firing_strengths"
EXPLANATION = {
    **dict.fromkeys(("weight", "drift", "aggregate", "prediction", "innovation", DEVIATION), POINT),
    STRENGTHS: JOINTS,
}
"""The topics below the node's own name, and their types."""

SENTENCE = "explanation"
"""The topic that says the same in words; ``explain`` says it of any bag, so none holds it."""


def point_template(types: TypeDescriptions, frame: str = "") -> Template:
    """Return a stamped scalar, in ``point.x``, to be filled.

    Args:
        types: Who describes message types.
        frame: Its ``frame_id``.
    """
    return ScalarCodec(types, POINT).template(default_message(types, POINT, frame))


def explain(point: Template, fused: Fused) -> Iterator[tuple[str, bytes]]:
    """Yield what stands behind an estimate: topic and message, one by one.

    Args:
        point: What :func:`point_template` returns.
        fused: The estimate. Without a prediction its two topics are silent, and so is the standard
            deviation while nothing is known of it.
    """
    for name, value in scalars(fused.estimate).items():
        yield name, point.filled(value, fused.stamp_ns)
    yield STRENGTHS, strengths_message(fused.estimate.aggregate.strengths, fused.stamp_ns)


def scalars(estimate: Estimate) -> dict[str, float]:
    """Return the numbers behind an estimate by their topics' names."""
    aggregate, prediction = estimate.aggregate, estimate.prediction
    known = {"weight": aggregate.weight, "drift": aggregate.drift, "aggregate": aggregate.value}
    if prediction.exists:
        known["prediction"] = prediction.value
        known["innovation"] = aggregate.value - prediction.value
    if estimate.standard_deviation > 0.0:
        known[DEVIATION] = estimate.standard_deviation
    return known


def strengths_message(strengths: FiringStrengths, stamp_ns: int) -> bytes:
    """Return the firing strengths by the names in ``RULES``, as positions of a JointState.

    Args:
        strengths: The strengths.
        stamp_ns: Stamp of the estimate, nanoseconds.
    """
    message = CdrWriter().stamp(stamp_ns).text("").count(len(RULES))
    for name in RULES:
        message.text(name)
    message.count(len(strengths))
    for strength in strengths:
        message.number("float64", strength)
    return message.count(0).count(0).done()  # neither velocities nor efforts


def text_message(text: str) -> bytes:
    """Return a text as a ``std_msgs/msg/String``."""
    return CdrWriter().text(text).done()


class EstimateMessages:
    """Makes messages of estimates: S2's latest with another number and stamp, or a type of its own.

    Never with S2's variance: ours where a field for it is named and it is known, else *unknown*.

    Attributes:
        codec: Tells their type, and where the estimate is in them.
    """

    def __init__(
        self, types: TypeDescriptions, parameters: EstimateParameters, s2: ScalarCodec
    ) -> None:
        """Settle type and field.

        Args:
            types: Who describes message types.
            parameters: Type and field where they are not S2's.
            s2: Reads S2.

        Raises:
            MessageError: The type is unknown or has no such fields, or the field is a function
                that cannot be inverted.
        """
        own = normalise_type_name(parameters.type) if parameters.type else s2.type_name
        self._copies_s2 = own == s2.type_name
        is_s2s = self._copies_s2 and not parameters.field
        self.codec = s2 if is_s2s else ScalarCodec(types, own, parameters.field)
        if self.codec.function.write is None:
            raise MessageError(
                f"the estimate cannot be written into field {self.codec.field.text!r} of {own}, "
                "which cannot be inverted: set estimate.type and estimate.field"
            )
        self._types = types
        self._s2 = s2
        self._s2_message: bytes | None = None
        variance = variance_of(types, own, self.codec.field)
        self._unknown = tuple(variance.unknown.values())
        self._unsure = Elements(types, own, list(variance.unknown))
        named = parameters.variance_field
        self._is_known = bool(named)
        self._variance = Elements(types, own, [named] if named else [])

    def message(self, fused: Fused) -> bytes:
        """Return the message of an estimate.

        Raises:
            MessageError: The number or the stamp does not fit into it.
        """
        if fused.s2_message is not self._s2_message:
            blank = self._unsure.written(self._like(fused.s2_message), self._unknown)
            self._template = self.codec.template(blank)
            self._s2_message = fused.s2_message
        data = self._template.filled(fused.estimate.value, fused.stamp_ns)
        deviation = fused.estimate.standard_deviation / self.codec.scale
        if self._is_known and deviation != 0.0:
            return self._variance.written(data, [deviation * deviation])
        return data

    def _like(self, s2_message: bytes) -> bytes:
        """Return a message to fill: the one of S2, or a default one in its frame."""
        if self._copies_s2 and s2_message:
            return s2_message
        frame = self._s2.frame(s2_message) if s2_message else ""
        return default_message(self._types, self.codec.type_name, frame)
