# SPDX-License-Identifier: Apache-2.0
"""What a message type consists of, whoever describes it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple, Protocol

from fuzzy_fusion_ros.messages.type_names import load_message_class

FLOATS = frozenset({"float32", "float64"})
INTEGER_RANGES: Mapping[str, tuple[int, int]] = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
NUMBERS = FLOATS | INTEGER_RANGES.keys()

_ROS_NAMES = {
    "boolean": "bool",
    "byte": "uint8",
    "char": "uint8",
    "double": "float64",
    "float": "float32",
    "octet": "uint8",
}
_SEQUENCE = re.compile(r"sequence<(.+?)(?:, (\d+))?>")
_ARRAY = re.compile(r"(.+)\[(\d+)\]")


class FieldType(NamedTuple):
    """The type of one field.

    Attributes:
        name: ``float64``, ``int32``, ``bool``, ``string`` and so on, or ``package/msg/Type``.
        is_array: Whether the field is an array (or sequence) of that.
        capacity: The size of a fixed array or the bound of a bounded one; None if unbounded.
        is_fixed: Whether the array always has that size.
    """

    name: str
    is_array: bool = False
    capacity: int | None = None
    is_fixed: bool = False

    @property
    def is_number(self) -> bool:
        """Whether one element is a number; a bool is none."""
        return self.name in NUMBERS

    @property
    def is_message(self) -> bool:
        """Whether one element is itself a message."""
        return "/" in self.name

    def __str__(self) -> str:
        """Return the type as a .msg file would spell it."""
        if not self.is_array:
            return self.name
        bound = "" if self.is_fixed or self.capacity is None else "<="
        return f"{self.name}[{bound}{self.capacity or ''}]"


class TypeDescriptions(Protocol):
    """Anything that can tell the fields of a message type."""

    def fields(self, type_name: str) -> Mapping[str, FieldType]:
        """Return the fields of ``package/msg/Type`` in their order.

        Raises:
            MessageError: The type is unknown.
        """
        ...


class InstalledTypes:
    """The message types of the sourced ROS 2 environment, described by their classes."""

    def fields(self, type_name: str) -> Mapping[str, FieldType]:
        """Return the fields of an installed type in their order.

        Raises:
            MessageError: The type is not installed.
        """
        described = load_message_class(type_name).get_fields_and_field_types()
        return {name: parse_field_type(text) for name, text in described.items()}


def parse_field_type(text: str) -> FieldType:
    """Return the type that a message class spells ``text``, such as ``sequence<double, 3>``."""
    if match := _SEQUENCE.fullmatch(text):
        return FieldType(_element_name(match[1]), True, int(match[2]) if match[2] else None)
    if match := _ARRAY.fullmatch(text):
        return FieldType(_element_name(match[1]), True, int(match[2]), True)
    return FieldType(_element_name(text))


def _element_name(text: str) -> str:
    name = text.partition("<")[0]
    package, slash, short = name.partition("/")
    return f"{package}/msg/{short}" if slash else _ROS_NAMES.get(name, name)
