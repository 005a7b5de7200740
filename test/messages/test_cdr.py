"""Padding is erased as rosbags would write it, and nothing else is touched."""

from __future__ import annotations

import random
import re
from typing import Any

import pytest
from rclpy.serialization import deserialize_message, serialize_message

from fuzzy_fusion_ros.bag import jazzy_types
from fuzzy_fusion_ros.messages import cdr, load_message_class
from fuzzy_fusion_ros.messages.cdr import padding_eraser

TYPES = (
    "builtin_interfaces/msg/Time",
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/PointStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "rcl_interfaces/msg/ParameterEvent",
    "sensor_msgs/msg/BatteryState",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/Range",
    "shape_msgs/msg/SolidPrimitive",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float64",
    "std_msgs/msg/Float64MultiArray",
    "std_msgs/msg/String",
)


def filled(type_name: str, generator: random.Random) -> Any:
    """A message whose texts and arrays are of any length."""
    message = load_message_class(type_name)()
    for name, text in message.get_fields_and_field_types().items():
        if match := re.fullmatch(r"sequence<(.+?)(?:, (\d+))?>", text):
            length = generator.randrange(min(int(match[2] or 4), 4) + 1)
            setattr(message, name, [value(match[1], generator) for _ in range(length)])
        elif match := re.fullmatch(r"(.+)\[(\d+)\]", text):
            setattr(message, name, [value(match[1], generator) for _ in range(int(match[2]))])
        else:
            setattr(message, name, value(text, generator))
    return message


def value(text: str, generator: random.Random) -> Any:
    """A value of one field or element."""
    if "/" in text:
        return filled(text.replace("/", "/msg/"), generator)
    if text.startswith("string"):
        return "x" * generator.randrange(9)
    if text == "boolean":
        return generator.random() < 0.5
    if text == "octet":
        return bytes([generator.randrange(256)])
    return generator.random() if text in {"float", "double"} else generator.randrange(100)


@pytest.mark.parametrize("type_name", TYPES)
def test_padding_is_what_rosbags_writes(type_name: str) -> None:
    generator = random.Random(type_name)
    erase = padding_eraser(type_name)
    types = jazzy_types()
    for _ in range(20):
        as_rclpy_has_it = serialize_message(filled(type_name, generator))
        kind = load_message_class(type_name)
        data = erase(as_rclpy_has_it)
        assert deserialize_message(data, kind) == deserialize_message(as_rclpy_has_it, kind)
        assert data == types.serialize(types.decode(type_name, data))


def test_dirt_in_the_padding_is_gone() -> None:
    message = load_message_class("geometry_msgs/msg/PointStamped")()
    clean = serialize_message(message)
    gap = slice(17, 20)  # behind the empty frame_id, before the first double
    dirty = clean[: gap.start] + b"\xff\xff\xff" + clean[gap.stop :]
    erased = padding_eraser("geometry_msgs/msg/PointStamped")(dirty)
    assert erased == clean[: gap.start] + bytes(3) + clean[gap.stop :]


@pytest.mark.parametrize(
    "data",
    [b"", b"\x00\x01", b"\x00\x00\x00\x00" + bytes(40), b"\x00\x01\x00\x00" + b"\xff" * 40],
    ids=["empty", "cut off", "big endian", "a text longer than the message"],
)
def test_what_is_laid_out_otherwise_stays_as_it_is(data: bytes) -> None:
    assert padding_eraser("geometry_msgs/msg/PointStamped")(data) == data


def test_types_with_wide_strings_stay_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    described = {"text": "wstring", "number": "double"}
    kind = type("Wide", (), {"get_fields_and_field_types": staticmethod(lambda: described)})
    monkeypatch.setattr(cdr, "load_message_class", lambda name: kind)
    data = b"\x00\x01\x00\x00" + b"\x01\x00\x00\x00" + b"\xff" * 12
    assert padding_eraser("some_msgs/msg/Wide")(data) == data
