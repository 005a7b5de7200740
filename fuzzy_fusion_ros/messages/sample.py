"""A message becomes a sample, a sample becomes a message."""

from __future__ import annotations

from typing import Any, TypeVar

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.copying import copy_message
from fuzzy_fusion_ros.messages.field_path import FieldPath

SECOND_NS = 1_000_000_000

_Message = TypeVar("_Message")


def sample_from_message(message: Any, field: FieldPath, receive_ns: int) -> Sample:
    """Return the sample that a message carries.

    The stamp is ``header.stamp``, else a bare ``stamp``, else the time of receipt.

    Args:
        message: A message of rclpy or of rosbags.
        field: Where its number is.
        receive_ns: When it was received, ns.

    Raises:
        MessageError: This message lacks the field or element, or it holds no number. NaN and
            infinite numbers pass through.
    """
    try:
        stamp = message.header.stamp
        return Sample(stamp.sec * SECOND_NS + stamp.nanosec, field.read(message))
    except AttributeError:
        stamp = _bare_stamp(message)
    stamp_ns = receive_ns if stamp is None else stamp.sec * SECOND_NS + stamp.nanosec
    return Sample(stamp_ns, field.read(message))


def is_stamped(message: Any) -> bool:
    """Return whether a message carries a stamp of its own, in its header or bare."""
    return _stamp(message) is not None


def copy_with(message: _Message, field: FieldPath, value: float, stamp_ns: int) -> _Message:
    """Return a copy of a message with another number and, if it has one, another stamp.

    Nothing is shared with the original, which stays as it is.

    Args:
        message: A message of rclpy or of rosbags.
        field: Where the number goes; a field of an integer type takes the nearest integer.
        value: The new number, unit of the field.
        stamp_ns: The new stamp, ns since the epoch of the message's clock.

    Raises:
        MessageError: The message lacks the field, or the number or stamp does not fit into it.
    """
    copied = copy_message(message)
    field.write(copied, value)
    stamp = _stamp(copied)
    if stamp is not None:
        seconds, nanoseconds = divmod(stamp_ns, SECOND_NS)
        if not -(2**31) <= seconds < 2**31:
            raise MessageError(f"stamp {stamp_ns} ns does not fit into 32-bit seconds")
        stamp.sec, stamp.nanosec = seconds, nanoseconds
    return copied


def _stamp(message: Any) -> Any:
    header_stamp = getattr(getattr(message, "header", None), "stamp", None)
    return header_stamp if hasattr(header_stamp, "nanosec") else _bare_stamp(message)


def _bare_stamp(message: Any) -> Any:
    stamp = getattr(message, "stamp", None)
    return stamp if hasattr(stamp, "nanosec") else None
