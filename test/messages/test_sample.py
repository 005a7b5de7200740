"""Samples from messages, and messages with another sample in them."""

from __future__ import annotations

import copy
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages.worlds import Rclpy, Rosbags, World

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.messages import (
    FieldPath,
    Sample,
    copy_message,
    copy_with,
    is_stamped,
    sample_from_message,
)

WORLDS: dict[str, World] = {"rclpy": Rclpy(), "rosbags": Rosbags()}
RECEIVED_NS = 42
STAMP = {"header.stamp.sec": 12, "header.stamp.nanosec": 345_678_901}
STAMP_NS = 12_345_678_901


@pytest.fixture(params=WORLDS)
def world(request: pytest.FixtureRequest) -> World:
    return WORLDS[request.param]


def test_the_stamp_is_that_of_the_header(world: World) -> None:
    message = world.new("geometry_msgs/msg/PointStamped", STAMP | {"point.x": 1.5})
    assert sample_from_message(message, FieldPath("point.x"), RECEIVED_NS) == (STAMP_NS, 1.5)
    assert is_stamped(message)


def test_a_bare_stamp_stands_in_for_a_header() -> None:
    message = WORLDS["rosbags"].new(
        "test_msgs/msg/StampData", {"stamp.sec": 3, "stamp.nanosec": 4, "data": 2.5}
    )
    assert sample_from_message(message, FieldPath("data"), RECEIVED_NS) == (3_000_000_004, 2.5)
    assert is_stamped(message)


def test_without_a_stamp_the_time_of_receipt_counts(world: World) -> None:
    message = world.new("std_msgs/msg/Float64", {"data": 2.5})
    assert sample_from_message(message, FieldPath("data"), RECEIVED_NS) == (RECEIVED_NS, 2.5)
    assert not is_stamped(message)


def test_a_header_or_stamp_of_another_kind_is_no_stamp() -> None:
    class Odd:
        header = "text"
        stamp = 3.5
        data = 1.0

    assert sample_from_message(Odd(), FieldPath("data"), RECEIVED_NS) == (RECEIVED_NS, 1.0)
    assert not is_stamped(Odd())


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_values_are_not_judged(world: World, value: float) -> None:
    message = world.new("std_msgs/msg/Float64", {"data": value})
    sample = sample_from_message(message, FieldPath("data"), RECEIVED_NS)
    assert repr(sample) == repr(Sample(RECEIVED_NS, value))


def test_stamps_before_the_epoch_are_negative(world: World) -> None:
    message = world.new("geometry_msgs/msg/PointStamped", {"header.stamp.sec": -2})
    assert sample_from_message(message, FieldPath("point.x"), 0).stamp_ns == -2_000_000_000


@pytest.mark.parametrize("text", ["point.w", "position[3]"])
def test_a_field_that_is_not_there_is_an_error_and_no_missing_stamp(
    world: World, text: str
) -> None:
    with pytest.raises(MessageError, match="has no field"):
        sample_from_message(world.new("geometry_msgs/msg/PointStamped"), FieldPath(text), 0)


@given(st.floats(), st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1))
def test_a_copy_carries_the_new_sample_and_the_original_the_old(
    value: float, stamp_ns: int
) -> None:
    for world in WORLDS.values():
        message = world.new(
            "geometry_msgs/msg/PointStamped",
            STAMP | {"point.x": 1.0, "point.y": 2.0, "header.frame_id": "pole"},
        )
        before = repr(message)
        copied = copy_with(message, FieldPath("point.x"), value, stamp_ns)
        sample = sample_from_message(copied, FieldPath("point.x"), 0)
        assert repr(sample) == repr(Sample(stamp_ns, value))
        assert type(copied) is type(message)
        assert (copied.header.frame_id, copied.point.y) == ("pole", 2.0)
        assert repr(message) == before


@pytest.mark.parametrize(
    ("msgtype", "values", "text"),
    [
        ("sensor_msgs/msg/JointState", {"name": ["a"], "position": [1.0]}, "name=a:position"),
        ("sensor_msgs/msg/JointState", {"name": ["a"], "position": [1.0]}, "position[0]"),
        ("sensor_msgs/msg/Imu", {}, "orientation_covariance[4]"),
        ("sensor_msgs/msg/Imu", {}, "linear_acceleration.x"),
        ("sensor_msgs/msg/Temperature", {}, "temperature"),
        ("sensor_msgs/msg/Range", {}, "range"),
        ("sensor_msgs/msg/FluidPressure", {}, "fluid_pressure"),
        ("std_msgs/msg/Float64", {}, "data"),
        ("std_msgs/msg/Float64MultiArray", {"data": [1.0, 2.0]}, "data[1]"),
        ("std_msgs/msg/Int32", {}, "data"),
        ("std_msgs/msg/UInt8MultiArray", {"data": [1, 2]}, "data[1]"),
    ],
)
def test_any_field_can_be_replaced(
    world: World, msgtype: str, values: dict[str, Any], text: str
) -> None:
    message = world.new(msgtype, values)
    before = repr(message)
    field = FieldPath(text)
    copied = copy_with(message, field, 5.0, STAMP_NS)
    assert sample_from_message(copied, field, STAMP_NS) == Sample(STAMP_NS, 5.0)
    assert repr(message) == before


def test_custom_types_can_be_replaced() -> None:
    world = WORLDS["rosbags"]
    message = world.new("test_msgs/msg/StampData")
    copied = copy_with(message, FieldPath("data"), 5.0, STAMP_NS)
    assert sample_from_message(copied, FieldPath("data"), 0) == (STAMP_NS, 5.0)
    nested = world.new("test_msgs/msg/Nested")
    nested.readings = [message]
    copied = copy_with(nested, FieldPath("readings[0].data"), 5.0, STAMP_NS)
    assert (copied.readings[0].data, message.data) == (5.0, 0.0)


@pytest.mark.parametrize(
    ("number", "value", "written"),
    [
        ("uint8", 2.4, 2),
        ("uint8", 2.6, 3),
        ("uint8", 255.4, 255),
        ("int8", -128.0, -128),
        ("int64", 2.0**62, 2**62),
    ],
)
def test_an_integer_field_takes_the_nearest_integer(
    world: World, number: str, value: float, written: int
) -> None:
    msgtype = {"uint8": "UInt8", "int8": "Int8", "int64": "Int64"}[number]
    message = world.new(f"std_msgs/msg/{msgtype}")
    copied = copy_with(message, FieldPath("data", number), value, 0)
    assert type(copied.data) is int
    assert copied.data == written


@pytest.mark.parametrize(
    ("number", "value"),
    [
        ("uint8", 256.0),
        ("uint8", -1.0),
        ("int8", 127.6),
        ("int64", 2.0**63),
        ("int8", math.nan),
        ("int8", math.inf),
    ],
)
def test_a_value_that_an_integer_field_cannot_hold_is_refused(number: str, value: float) -> None:
    message = WORLDS["rosbags"].new("std_msgs/msg/Int64")
    with pytest.raises(MessageError, match=rf"'data' is of type {number}, .* does not fit"):
        copy_with(message, FieldPath("data", number), value, 0)


def test_bytes_of_rclpy_are_replaced() -> None:
    world = WORLDS["rclpy"]
    copied = copy_with(world.new("std_msgs/msg/Byte", {"data": b"\x01"}), FieldPath("data"), 7, 0)
    assert copied.data == b"\x07"
    many = world.new("std_msgs/msg/ByteMultiArray", {"data": [b"\x01", b"\x02"]})
    copied = copy_with(many, FieldPath("data[1]"), 7.0, 0)
    assert (copied.data, many.data) == ([b"\x01", b"\x07"], [b"\x01", b"\x02"])
    packed = world.new("std_msgs/msg/ByteMultiArray", {"data": b"\x01\x02"})
    copied = copy_with(packed, FieldPath("data[1]"), 7.0, 0)
    assert (copied.data, packed.data) == (b"\x01\x07", b"\x01\x02")
    with pytest.raises(MessageError, match=r"300\.0 does not fit"):
        copy_with(packed, FieldPath("data[1]"), 300.0, 0)


@pytest.mark.parametrize("stamp_ns", [2**31 * 10**9, -(2**31) * 10**9 - 1])
def test_a_stamp_that_does_not_fit_is_refused(world: World, stamp_ns: int) -> None:
    message = world.new("geometry_msgs/msg/PointStamped")
    with pytest.raises(MessageError, match="does not fit into 32-bit seconds"):
        copy_with(message, FieldPath("point.x"), 0.0, stamp_ns)


def test_a_path_that_the_message_lacks_is_refused(world: World) -> None:
    with pytest.raises(MessageError, match="has no field 'w'"):
        copy_with(world.new("geometry_msgs/msg/PointStamped"), FieldPath("point.w"), 0.0, 0)


@pytest.mark.parametrize(
    "msgtype",
    [
        "sensor_msgs/msg/CameraInfo",
        "sensor_msgs/msg/BatteryState",
        "diagnostic_msgs/msg/DiagnosticArray",
        "std_msgs/msg/Float64MultiArray",
    ],
)
def test_a_copy_equals_and_shares_nothing(world: World, msgtype: str) -> None:
    message = world.new(msgtype)
    copied = copy_message(message)
    assert repr(copied) == repr(copy.deepcopy(message)) == repr(message)
    assert not (mutable_parts(copied) & mutable_parts(message))


def mutable_parts(message: Any) -> set[int]:
    """Return the identities of all sub-messages and arrays."""
    if isinstance(message, float | int | str | bytes):
        return set()
    if isinstance(message, list):
        return {id(message)}.union(*map(mutable_parts, message))
    names: Any = getattr(message, "__dataclass_fields__", getattr(message, "__slots__", ()))
    return {id(message)}.union(*(mutable_parts(getattr(message, name)) for name in names))
