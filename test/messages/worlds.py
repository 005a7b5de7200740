# SPDX-License-Identifier: Apache-2.0
"""Messages of rclpy and of rosbags, made and serialised the same way."""

from __future__ import annotations

import array
import operator
import random
import re
from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np
from rclpy.serialization import serialize_message
from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic
from fuzzy_fusion_ros.messages import InstalledTypes, TypeDescriptions, load_message_class

CUSTOM = {
    "test_msgs/msg/HeaderValue": """
std_msgs/Header header
float64 value
float64 variance
bool valid
""",
    "test_msgs/msg/StampData": """
builtin_interfaces/Time stamp
float64 data
""",
    "test_msgs/msg/Numbers": """
int8 tiny
uint8 small
byte raw
char letter
int64 wide
uint64 widest
float32 single
float64[3] fixed
float64[<=2] bounded
int16[] whole
byte[] bytes_
string[] names
bool yes
""",
    "test_msgs/msg/Nested": """
test_msgs/StampData[] readings
sensor_msgs/JointState joints
""",
}


class World(Protocol):
    """A maker of messages.

    Attributes:
        types: The types of its messages.
    """

    types: TypeDescriptions

    def new(self, msgtype: str, values: Mapping[str, Any] | None = None) -> Any:
        """Return a message with zeros everywhere but at the given dotted paths."""
        ...

    def serialized(self, message: Any) -> bytes:
        """Return a message as bytes."""
        ...

    def data(self, msgtype: str, values: Mapping[str, Any] | None = None) -> bytes:
        """Return a new message as bytes."""
        return self.serialized(self.new(msgtype, values))


class Rclpy(World):
    """Messages that rclpy would publish."""

    types = InstalledTypes()

    def new(self, msgtype: str, values: Mapping[str, Any] | None = None) -> Any:
        """Return a message with zeros everywhere but at the given dotted paths."""
        return fill(load_message_class(msgtype)(), values)

    def serialized(self, message: Any) -> bytes:
        """Return a message as bytes, padding as it happens to be."""
        return bytes(serialize_message(message))

    def filled(self, msgtype: str, generator: random.Random) -> Any:
        """Return a message whose texts and arrays are of any length."""
        message = load_message_class(msgtype)()
        for name, text in message.get_fields_and_field_types().items():
            if match := re.fullmatch(r"sequence<(.+?)(?:, (\d+))?>", text):
                length = generator.randrange(min(int(match[2] or 4), 4) + 1)
                value: Any = [self._value(match[1], generator) for _ in range(length)]
            elif match := re.fullmatch(r"(.+)\[(\d+)\]", text):
                value = [self._value(match[1], generator) for _ in range(int(match[2]))]
            else:
                value = self._value(text, generator)
            setattr(message, name, value)
        return message

    def _value(self, text: str, generator: random.Random) -> Any:
        if "/" in text:
            return self.filled(text.replace("/", "/msg/"), generator)
        if text.startswith("string"):
            return "x" * generator.randrange(9)
        if text == "boolean":
            return generator.random() < 0.5
        if text == "octet":
            return bytes([generator.randrange(256)])
        return (
            float(generator.randrange(100))
            if text in {"float", "double"}
            else generator.randrange(100)
        )

    def numbers(self, message: Any, prefix: str = "") -> Iterator[tuple[str, float]]:
        """Yield the path and value of every number in a message, those of a byte left out."""
        for name in message.get_fields_and_field_types():
            value = getattr(message, name)
            is_array = hasattr(value, "__len__") and not isinstance(value, str | bytes)
            elements = {f"[{k}]": each for k, each in enumerate(value)} if is_array else {"": value}
            for index, each in elements.items():
                path = f"{prefix}{name}{index}"
                if hasattr(each, "get_fields_and_field_types"):
                    yield from self.numbers(each, f"{path}.")
                elif not isinstance(each, str | bytes | bool):
                    yield path, float(each)


class Rosbags(World):
    """Messages that rosbags would read, also of types that nobody installed."""

    def __init__(self) -> None:
        self.store = get_typestore(Stores.ROS2_JAZZY)
        for name, text in CUSTOM.items():
            self.store.register(get_types_from_msg(text, name))
        definitions = {name: self.store.generate_msgdef(name, ros_version=2)[0] for name in CUSTOM}
        self.types = BagTypes(
            Topic(f"/{name}", name, definition=Definition("ros2msg", text))
            for name, text in definitions.items()
        )

    def new(self, msgtype: str, values: Mapping[str, Any] | None = None) -> Any:
        """Return a message with zeros everywhere but at the given dotted paths."""
        fields = {name: self._zero(each) for name, each in self.store.fielddefs[msgtype][1]}
        return fill(self.store.types[msgtype](**fields), values)

    def serialized(self, message: Any) -> bytes:
        """Return a message as bytes."""
        return bytes(self.store.serialize_cdr(message, message.__msgtype__))

    def _zero(self, described: Any) -> Any:
        kind, what = described
        if kind == Nodetype.NAME:
            return self.new(what)
        if kind == Nodetype.BASE:
            return {"string": "", "bool": False}.get(what[0], 0.0 if "float" in what[0] else 0)
        (inner, name), size = what
        if inner == Nodetype.NAME or name[0] == "string":
            return [self._zero((inner, name)) for _ in range(size if kind == Nodetype.ARRAY else 0)]
        dtype = {"byte": "uint8", "char": "uint8"}.get(name[0], name[0])
        return np.zeros(size if kind == Nodetype.ARRAY else 0, dtype=dtype)


def fill(message: Any, values: Mapping[str, Any] | None) -> Any:
    """Set fields at dotted paths, arrays in the form in which the message holds them."""
    for path, value in (values or {}).items():
        *owners, name = path.split(".")
        owner = operator.attrgetter(".".join(owners))(message) if owners else message
        old = getattr(owner, name)
        if isinstance(old, array.array):
            value = array.array(old.typecode, value)
        elif isinstance(old, np.ndarray):
            value = np.array(value, dtype=old.dtype)
        setattr(owner, name, value)
    return message
