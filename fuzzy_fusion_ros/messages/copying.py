"""Copies of messages, of rclpy or of rosbags, that share nothing with the original."""

from __future__ import annotations

import array
from typing import Any, TypeVar

import numpy as np

_Message = TypeVar("_Message")

_IMMUTABLE = (float, int, str, bytes, np.generic)


def copy_message(message: _Message) -> _Message:
    """Return a copy of a message, its arrays and sub-messages copied too.

    It is some ten times faster than :func:`copy.deepcopy`, since messages are trees.
    """
    cls = type(message)
    copied = cls.__new__(cls)
    for name in _field_slots(cls):
        setattr(copied, name, _copy_value(getattr(message, name)))
    return copied


def _field_slots(cls: Any) -> Any:
    """Return the attributes that hold a message's fields: slots for rclpy, else dataclass."""
    return getattr(cls, "__dataclass_fields__", None) or cls.__slots__


def _copy_value(value: Any) -> Any:
    if isinstance(value, _IMMUTABLE):
        return value
    if isinstance(value, list):
        return [_copy_value(each) for each in value]
    if isinstance(value, np.ndarray):
        return value.copy()
    if isinstance(value, array.array):
        return value[:]
    return copy_message(value)
