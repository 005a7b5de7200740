# SPDX-License-Identifier: Apache-2.0
"""Serialised messages: CDR, as ROS 2 writes it.

Instead of rclpy's and rosbags' serialisation because stamp and number are replaced in a message
whose other bytes stay as they are, and read in 0.3 to 0.7 of rosbags' CPU time and 0.1 to 0.4 of
rclpy's (measured by test/bench/bags.py and test/messages/test_codec.py).

A message is its fields, one after another. A number is aligned to its own size, counted from the
end of the encapsulation header; texts and sequences begin with a count, nothing else does.
"""

from __future__ import annotations

import struct

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.parameters.errors import MessageError

ORIGIN = 4
"""Bytes of encapsulation header; alignment counts from its end."""

LITTLE_ENDIAN = b"\x00\x01\x00\x00"
ORDERS = {b"\x00\x01": "<", b"\x00\x00": ">"}
"""Byte orders, as :mod:`struct` writes them, by how messages begin."""

PADDING_BYTES = 3
"""Most bytes that may follow a message: the payload is padded to a multiple of four."""

EMPTY_ARRAY_BYTES = 8
"""Most bytes that rclpy may append to a message for each empty array in it: it sizes the buffer as
if the elements of such an array were aligned, but returns all of it."""

LARGEST = 64 << 20
"""Most bytes of a message that is created here."""

FORMATS = {
    "bool": "?",
    "float32": "f",
    "float64": "d",
    "int8": "b",
    "int16": "h",
    "int32": "i",
    "int64": "q",
    "uint8": "B",
    "uint16": "H",
    "uint32": "I",
    "uint64": "Q",
}
SIZES = {name: struct.calcsize(f"<{each}") for name, each in FORMATS.items()}


class CdrWriter:
    """Writes a message field by field, little endian, padding zero."""

    def __init__(self) -> None:
        """Begin."""
        self._data = bytearray(LITTLE_ENDIAN)

    def number(self, name: str, value: float) -> CdrWriter:
        """Write a number of a type such as ``float64``, or a bool; return the writer itself."""
        self.aligned(name)._data += struct.pack(f"<{FORMATS[name]}", value)
        return self

    def numbers(self, name: str, value: float, count: int) -> CdrWriter:
        """Write the same number several times; return the writer itself.

        Raises:
            MessageError: The message becomes larger than ``LARGEST``.
        """
        if len(self._data) + count * SIZES[name] > LARGEST:
            raise MessageError(f"an array of {count} numbers makes messages too large to be sent")
        if count:
            self.aligned(name)._data += count * struct.pack(f"<{FORMATS[name]}", value)
        return self

    def aligned(self, name: str) -> CdrWriter:
        """Pad to where a number of a type may begin; return the writer itself."""
        self._data += bytes(-(len(self._data) - ORIGIN) % SIZES[name])
        return self

    def count(self, elements: int) -> CdrWriter:
        """Write how many elements a sequence has; return the writer itself."""
        return self.number("uint32", elements)

    def text(self, text: str) -> CdrWriter:
        """Write a text; return the writer itself."""
        encoded = text.encode() + b"\0"
        self.count(len(encoded))
        self._data += encoded
        return self

    def stamp(self, stamp_ns: int) -> CdrWriter:
        """Write a stamp, given in nanoseconds; return the writer itself."""
        seconds, nanoseconds = divmod(stamp_ns, SECOND_NS)
        return self.number("int32", seconds).number("uint32", nanoseconds)

    def done(self) -> bytes:
        """Return all that was written."""
        return bytes(self._data)
