# SPDX-License-Identifier: Apache-2.0
"""Serialised messages with nothing in them yet."""

from __future__ import annotations

from fuzzy_fusion_ros.messages.cdr import SIZES, CdrWriter
from fuzzy_fusion_ros.messages.type_fields import FieldType, TypeDescriptions

HEADER = "std_msgs/msg/Header"

_DEFAULTS = {("geometry_msgs/msg/Quaternion", "w"): 1.0}
"""Non-zero defaults of common ROS types: a default pose has the identity rotation."""


def default_message(types: TypeDescriptions, type_name: str, frame: str = "") -> bytes:
    """Return a serialised message of zeros, empty texts and empty sequences.

    Args:
        types: Who describes message types.
        type_name: ``package/msg/Type``.
        frame: The ``frame_id`` of its header, if it has one.

    Raises:
        MessageError: The type, or one in it, is unknown, or even an empty message is too large.
    """
    writer = CdrWriter()
    _write_message(writer, types, type_name, frame)
    return writer.done()


def _write_message(writer: CdrWriter, types: TypeDescriptions, name: str, frame: str) -> None:
    fields = types.fields(name)
    if not fields:
        writer.number("uint8", 0)  # nothing is empty in CDR
    for each, field in fields.items():
        if name == HEADER and each == "frame_id":
            writer.text(frame)
        else:
            _write_field(writer, types, field, _DEFAULTS.get((name, each), 0.0), frame)


def _write_field(
    writer: CdrWriter, types: TypeDescriptions, field: FieldType, number: float, frame: str
) -> None:
    if field.is_array and not field.is_fixed:
        writer.count(0)
        return
    count = field.capacity or 0 if field.is_array else 1
    if field.name in SIZES:
        writer.numbers(field.name, number if field.name.startswith("float") else 0, count)
        return
    for _ in range(count):
        if field.is_message:
            _write_message(writer, types, field.name, frame)
        else:
            writer.text("")
