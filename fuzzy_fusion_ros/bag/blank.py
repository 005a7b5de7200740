"""Messages with nothing in them yet."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy_fusion_ros.bag.typestore import BagTypes
from fuzzy_fusion_ros.messages.type_fields import FieldType


def blank_message(types: BagTypes, msgtype: str) -> Any:
    """Return a message as rosbags' dataclass: zeros, empty texts, as few elements as can be.

    A bounded array gets as many elements as it can hold; a bag does not tell it from a fixed one.

    Args:
        types: The types of the bag.
        msgtype: ``package/msg/Type``.

    Raises:
        BagError: The type is not known.
        MessageError: One that it contains is not.
    """
    cls = types.message_class(msgtype)
    return cls(**{name: _blank(types, field) for name, field in types.fields(msgtype).items()})


def _blank(types: BagTypes, field: FieldType) -> Any:
    if not field.is_array:
        return _blank_element(types, field.name)
    size = field.capacity or 0
    if field.is_number or field.name == "bool":
        return np.zeros(size, dtype=field.name)
    return [_blank_element(types, field.name) for _ in range(size)]


def _blank_element(types: BagTypes, name: str) -> Any:
    if "/" in name:
        return blank_message(types, name)
    if name in {"string", "wstring"}:
        return ""
    if name == "bool":
        return False
    return 0.0 if name.startswith("float") else 0
