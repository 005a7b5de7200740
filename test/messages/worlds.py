"""Messages of rclpy and of rosbags, made the same way."""

from __future__ import annotations

import array
import operator
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
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
    """A maker of messages."""

    @property
    def types(self) -> TypeDescriptions:
        """The types of its messages."""
        ...

    def new(self, msgtype: str, values: Mapping[str, Any] | None = None) -> Any:
        """Return a message with zeros everywhere but at the given dotted paths."""
        ...


class Rclpy:
    """Messages that rclpy would publish."""

    def __init__(self) -> None:
        self.types = InstalledTypes()

    def new(self, msgtype: str, values: Mapping[str, Any] | None = None) -> Any:
        """Return a message with zeros everywhere but at the given dotted paths."""
        return fill(load_message_class(msgtype)(), values)


class Rosbags:
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
