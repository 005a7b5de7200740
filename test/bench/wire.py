# SPDX-License-Identifier: Apache-2.0
"""Serialised samples, made and read without rclpy's conversions: the meter is to cost little."""

from __future__ import annotations

import struct
import time

from geometry_msgs.msg import PointStamped
from rclpy.serialization import serialize_message

_STAMP = struct.Struct("<iI")
_STAMP_AT = 4
_VALUES = struct.Struct("<3d")
_VALUES_AT = 20
_BLANK = bytes(serialize_message(PointStamped()))


def sample(stamp_ns: int, value: float) -> bytes:
    """Return a ``PointStamped`` as it is on the wire, with one value in all of its fields."""
    data = bytearray(_BLANK)
    _STAMP.pack_into(data, _STAMP_AT, *divmod(stamp_ns, 1_000_000_000))
    _VALUES.pack_into(data, _VALUES_AT, value, value, value)
    return bytes(data)


def stamp_of(data: bytes) -> int:
    """Return the stamp of a serialised message that begins with a header, nanoseconds."""
    seconds, nanoseconds = _STAMP.unpack_from(data, _STAMP_AT)
    return int(seconds) * 1_000_000_000 + int(nanoseconds)


def age_of(data: bytes) -> float:
    """Return how long ago a message was stamped, seconds."""
    return (time.time_ns() - stamp_of(data)) * 1e-9
