"""Serialised messages whose bytes depend on their content alone.

CDR aligns numbers by padding, and rclpy leaves in the padding, and sometimes behind the end,
what happened to be in memory: the same run would give other bytes each time. Here padding is
zero and nothing is behind the end, as rosbags has it.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from fuzzy_fusion_ros.messages.type_names import load_message_class

Step = Callable[[bytearray, int], int]
"""Zeroes the padding of one field, given where the last ended; returns where this one ends."""

ORIGIN = 4
"""Bytes of encapsulation header; alignment counts from behind it."""

LITTLE_ENDIAN = b"\x00\x01"

_SIZES = {
    **dict.fromkeys(("boolean", "octet", "byte", "char", "int8", "uint8"), 1),
    **dict.fromkeys(("int16", "uint16"), 2),
    **dict.fromkeys(("int32", "uint32", "float"), 4),
    **dict.fromkeys(("int64", "uint64", "double"), 8),
}
_ARRAY = re.compile(r"(?:sequence<(?P<element>.+?)(?:, \d+)?>|(?P<item>.+)\[(?P<length>\d+)\])")


def padding_eraser(type_name: str) -> Callable[[bytes], bytes]:
    """Return a function that cleans serialised messages of an installed type.

    Bytes that are not laid out as expected come back as they are.

    Args:
        type_name: ``package/msg/Type``.

    Raises:
        MessageError: The type is not installed.
    """
    step = _message(type_name)

    def erase(data: bytes) -> bytes:
        if not data.startswith(LITTLE_ENDIAN):
            return data
        erased = bytearray(data)
        end = step(erased, ORIGIN)
        return bytes(erased[:end]) if end <= len(data) else data

    return erase


def _message(type_name: str) -> Step:
    described = load_message_class(type_name).get_fields_and_field_types()
    steps = [_field(text) for text in described.values()] or [_number(1)]  # none is empty in CDR

    def walk(data: bytearray, at: int) -> int:
        for step in steps:
            at = step(data, at)
        return at

    return walk


def _field(text: str) -> Step:
    match = _ARRAY.fullmatch(text)
    if match is None:
        return _single(text)
    name = match["element"] or match["item"]
    return _array(_single(name), _SIZES.get(name, 0), match["length"])


def _single(name: str) -> Step:
    if name in _SIZES:
        return _number(_SIZES[name])
    if "/" in name:
        return _message(name)
    return _unknown if name.startswith("wstring") else _string


def _array(element: Step, size: int, length: str | None) -> Step:
    """Return the step of an array; ``size`` is that of a number, 0 for anything else."""

    def walk(data: bytearray, at: int) -> int:
        if length is None:
            at = _length(data, at)
            count = int.from_bytes(data[at - 4 : at], "little")
        else:
            count = int(length)
        if size and count:
            return element(data, at) + (count - 1) * size
        for _ in range(min(count, len(data))):
            at = element(data, at)
        return at

    return walk


def _number(size: int) -> Step:
    zeros = [bytes(gap) for gap in range(size)]

    def walk(data: bytearray, at: int) -> int:
        gap = (ORIGIN - at) % size
        if gap:
            data[at : at + gap] = zeros[gap]
        return at + gap + size

    return walk


_length = _number(4)


def _string(data: bytearray, at: int) -> int:
    at = _length(data, at)
    return at + int.from_bytes(data[at - 4 : at], "little")


def _unknown(data: bytearray, at: int) -> int:
    """Give up: the end will not be where it should be."""
    return at + len(data) + 1
