# SPDX-License-Identifier: Apache-2.0
"""Fields of types, as classes and as bags describe them."""

from __future__ import annotations

import pytest
from messages.worlds import Rosbags

from fuzzy_fusion_ros.messages import FieldType, InstalledTypes
from fuzzy_fusion_ros.messages.type_fields import parse_field_type
from fuzzy_fusion_ros.parameters.errors import MessageError


@pytest.mark.parametrize(
    ("text", "parsed", "shown"),
    [
        ("double", FieldType("float64"), "float64"),
        ("float", FieldType("float32"), "float32"),
        ("octet", FieldType("uint8"), "uint8"),
        ("boolean", FieldType("bool"), "bool"),
        ("uint64", FieldType("uint64"), "uint64"),
        ("string", FieldType("string"), "string"),
        ("string<10>", FieldType("string"), "string"),
        ("wstring", FieldType("wstring"), "wstring"),
        ("std_msgs/Header", FieldType("std_msgs/msg/Header"), "std_msgs/msg/Header"),
        ("double[9]", FieldType("float64", True, 9, True), "float64[9]"),
        ("sequence<double>", FieldType("float64", True), "float64[]"),
        ("sequence<double, 3>", FieldType("float64", True, 3), "float64[<=3]"),
        ("sequence<string>", FieldType("string", True), "string[]"),
        ("sequence<string<5>>", FieldType("string", True), "string[]"),
        ("sequence<string<5>, 3>", FieldType("string", True, 3), "string[<=3]"),
        (
            "sequence<geometry_msgs/Point>",
            FieldType("geometry_msgs/msg/Point", True),
            "geometry_msgs/msg/Point[]",
        ),
    ],
)
def test_a_field_type_is_parsed_and_shown(text: str, parsed: FieldType, shown: str) -> None:
    assert parse_field_type(text) == parsed
    assert str(parsed) == shown


@pytest.mark.parametrize(
    ("field", "is_number", "is_message"),
    [
        (FieldType("float64"), True, False),
        (FieldType("uint8"), True, False),
        (FieldType("int64", True), True, False),
        (FieldType("bool"), False, False),
        (FieldType("string"), False, False),
        (FieldType("std_msgs/msg/Header"), False, True),
    ],
)
def test_a_bool_is_no_number(field: FieldType, is_number: bool, is_message: bool) -> None:
    assert (field.is_number, field.is_message) == (is_number, is_message)


@pytest.mark.parametrize(
    "name",
    [
        "geometry_msgs/msg/PointStamped",
        "sensor_msgs/msg/BatteryState",
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/Imu",
        "sensor_msgs/msg/JointState",
        "std_msgs/msg/Float64MultiArray",
        "std_msgs/msg/Byte",
        "std_msgs/msg/Char",
        "diagnostic_msgs/msg/DiagnosticArray",
        "trajectory_msgs/msg/JointTrajectoryPoint",
    ],
)
def test_classes_and_bags_describe_a_type_alike(name: str) -> None:
    assert InstalledTypes().fields(name) == Rosbags().types.fields(name)


def test_a_type_that_the_bag_does_not_describe_is_refused() -> None:
    with pytest.raises(MessageError, match="'no_msgs/msg/Nothing' is neither described by"):
        Rosbags().types.fields("no_msgs/msg/Nothing")
