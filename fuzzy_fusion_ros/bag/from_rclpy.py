"""Messages of rclpy as rosbags' dataclasses."""

from __future__ import annotations

from typing import Any

import numpy as np
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

_FILLER = "structure_needs_at_least_one_member"  # of empty messages; rclpy does not show it


def dataclass_from_rclpy(message: Any, msgtype: str, store: Typestore) -> Any:
    """Return a message of rclpy as the dataclass that rosbags has for its type.

    Args:
        message: A message of rclpy.
        msgtype: Its type, ``package/msg/Type``.
        store: The types that rosbags knows.

    Raises:
        AttributeError: The message lacks a field of the type.
        ValueError: An array holds what is no number.
    """
    described: list[tuple[str, Any]] = store.fielddefs[msgtype][1]
    values = {
        name: _value(getattr(message, name), each, store)
        for name, each in described
        if name != _FILLER
    }
    return store.types[msgtype](**values)


def _value(value: Any, described: Any, store: Typestore) -> Any:
    kind, what = described
    if kind == Nodetype.NAME:
        return dataclass_from_rclpy(value, what, store)
    if kind == Nodetype.BASE:
        # rclpy has a byte as bytes of length 1, rosbags as a signed number.
        return int.from_bytes(value, "little", signed=True) if what[0] == "byte" else value
    (inner, element), _ = what
    if inner == Nodetype.NAME:
        return [dataclass_from_rclpy(each, element, store) for each in value]
    if element[0] == "string":
        return value
    if element[0] == "byte":
        joined = value if isinstance(value, bytes) else b"".join(value)
        return np.frombuffer(joined, dtype=np.uint8)
    return np.asarray(value, dtype={"char": "uint8"}.get(element[0], element[0]))
