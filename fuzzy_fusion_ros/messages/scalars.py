"""Numbers as message fields hold them."""

from __future__ import annotations

import math
import numbers
from typing import Any

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.messages.type_fields import INTEGER_RANGES


def as_float(value: object, number: str, name: str) -> float:
    """Return the number that a field holds.

    Args:
        value: A number, or the single byte that rclpy gives for a ``byte`` field.
        number: The type of the field, such as ``float64``.
        name: The path of the field, for the error.

    Raises:
        MessageError: The value is a bool, a text, a message or an array.
    """
    if isinstance(value, (float, int)) and not isinstance(value, bool):
        # rosbags reads a byte as signed, rclpy as unsigned
        return float(value) + 256.0 if value < 0 and number == "uint8" else float(value)
    if isinstance(value, bytes) and len(value) == 1:
        return float(value[0])
    if isinstance(value, bool) or not isinstance(value, numbers.Real):  # numpy's are Real
        raise MessageError(f"field {name!r} holds a {type(value).__name__}, no number")
    return float(value)


def like(current: Any, value: float, number: str, name: str) -> Any:
    """Return ``value`` in the form in which a field holds its ``current`` value.

    Args:
        current: What the field holds now.
        value: The new value; an integer field takes the nearest integer.
        number: The type of the field, such as ``float64``; it limits integers.
        name: The path of the field, for the error.

    Raises:
        MessageError: The value is not finite or too large, and the field is of an integer type.
    """
    if isinstance(current, numbers.Real) and not isinstance(current, numbers.Integral):
        return float(value)
    low, high = INTEGER_RANGES.get(number, (-math.inf, math.inf))
    if isinstance(current, bytes):
        low, high = 0, 255
    if not (math.isfinite(value) and low <= round(value) <= high):
        kind = number if number in INTEGER_RANGES else "integer"
        raise MessageError(f"field {name!r} is of type {kind}, {value!r} does not fit")
    return bytes([round(value)]) if isinstance(current, bytes) else round(value)
