# SPDX-License-Identifier: Apache-2.0
"""Samples from serialised messages, and messages with another sample in them."""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Mapping
from typing import Any

import pytest
from bag.making import STORE, decoded
from hypothesis import given
from hypothesis import strategies as st
from messages.worlds import World
from rclpy.serialization import deserialize_message, serialize_message

from fuzzy_fusion_ros.bag import BagMessage
from fuzzy_fusion_ros.messages import (
    FieldType,
    InstalledTypes,
    Sample,
    ScalarCodec,
    default_message,
    load_message_class,
)
from fuzzy_fusion_ros.parameters.errors import MessageError

RECEIVED_NS = 42
STAMP = {"header.stamp.sec": 12, "header.stamp.nanosec": 345_678_901}
STAMP_NS = 12_345_678_901
POINT = "geometry_msgs/msg/PointStamped"
JOINT_STATE = "sensor_msgs/msg/JointState"
JOINTS = {"name": ["cart", "pole"], "position": [1.0, 2.0], "velocity": [3.0, 4.0]}


def sample(world: World, msgtype: str, values: Mapping[str, Any], field: str = "") -> Sample:
    """The sample in a message."""
    codec = ScalarCodec(world.types, msgtype, field)
    return codec.sample(world.data(msgtype, values), RECEIVED_NS)


def test_the_stamp_is_that_of_the_header(world: World) -> None:
    assert sample(world, POINT, STAMP | {"point.x": 1.5}) == Sample(STAMP_NS, 1.5)
    assert ScalarCodec(world.types, POINT).is_stamped


def test_a_bare_stamp_stands_in_for_a_header(rosbags: World) -> None:
    values = {"stamp.sec": 3, "stamp.nanosec": 4, "data": 2.5}
    assert sample(rosbags, "test_msgs/msg/StampData", values) == Sample(3_000_000_004, 2.5)
    assert ScalarCodec(rosbags.types, "test_msgs/msg/StampData").is_stamped


def test_without_a_stamp_the_time_of_receipt_counts(world: World) -> None:
    assert sample(world, "std_msgs/msg/Float64", {"data": 2.5}) == Sample(RECEIVED_NS, 2.5)
    assert not ScalarCodec(world.types, "std_msgs/msg/Float64").is_stamped


class Described:
    """Types described by the test itself."""

    def __init__(self, types: Mapping[str, Mapping[str, FieldType]]) -> None:
        self._types = types

    def fields(self, type_name: str) -> Mapping[str, FieldType]:
        """Return the fields of a type."""
        return self._types[type_name]


@pytest.mark.parametrize(
    ("fields", "begin"),
    [
        ({"header": FieldType("string"), "stamp": FieldType("float64")}, "01000000 00" + 11 * "00"),
        ({"header": FieldType("a_msgs/msg/B"), "stamp": FieldType("uint8", True, 2, True)}, "0102"),
    ],
    ids=["no message", "a message without a stamp"],
)
def test_a_header_or_stamp_of_another_kind_is_no_stamp(
    fields: dict[str, FieldType], begin: str
) -> None:
    types = {"a_msgs/msg/A": fields | {"data": FieldType("float64")}, "a_msgs/msg/B": {}}
    codec = ScalarCodec(Described(types), "a_msgs/msg/A", "data")
    before = bytes.fromhex(begin)
    data = b"\0\1\0\0" + before.ljust(-(-len(before) // 8) * 8, b"\0") + struct.pack("<d", 1.0)
    assert not codec.is_stamped
    assert codec.sample(data, RECEIVED_NS) == Sample(RECEIVED_NS, 1.0)
    assert codec.frame(data) == ""


@pytest.mark.parametrize(
    ("header", "time"),
    [
        ({"Drame_id": FieldType("string")}, ["sec", "nanosec"]),
        ({"frame_id": FieldType("uint32")}, ["sec", "nanosec"]),
        ({"frame_id": FieldType("string")}, ["secs", "nanosec"]),
    ],
    ids=["another name", "another type", "another time"],
)
def test_a_header_is_what_the_bag_says_it_is(header: dict[str, FieldType], time: list[str]) -> None:
    types = {
        "a_msgs/msg/A": {"header": FieldType("std_msgs/msg/Header"), "data": FieldType("float64")},
        "std_msgs/msg/Header": {"stamp": FieldType("builtin_interfaces/msg/Time")} | header,
        "builtin_interfaces/msg/Time": dict(
            zip(time, [FieldType("int32"), FieldType("uint32")], strict=True)
        ),
    }
    codec = ScalarCodec(Described(types), "a_msgs/msg/A", "data")
    data = b"\0\1\0\0" + struct.pack("<iI8xd", 3, 4, 1.5)
    is_time = time[0] == "sec"
    assert codec.is_stamped == is_time
    assert codec.sample(data, 42) == Sample(3_000_000_004 if is_time else 42, 1.5)
    assert codec.frame(data) == ""


def test_stamps_before_the_epoch_are_negative(world: World) -> None:
    assert sample(world, POINT, {"header.stamp.sec": -2}).stamp_ns == -2_000_000_000


@pytest.mark.parametrize(
    ("msgtype", "values", "text", "value"),
    [
        (POINT, {"point.x": 1.5}, "point.x", 1.5),
        (POINT, {"point.z": -2.5, "header.frame_id": "a longer frame"}, "point.z", -2.5),
        (POINT, {"header.stamp.sec": 7}, "header.stamp.sec", 7.0),
        ("std_msgs/msg/Float64", {"data": 0.1}, "data", 0.1),
        ("std_msgs/msg/Float64", {"data": math.inf}, "data", math.inf),
        ("std_msgs/msg/Float64", {"data": math.nan}, "data", math.nan),
        ("std_msgs/msg/Float64", {"data": -0.0}, "data", -0.0),
        ("std_msgs/msg/Float32", {"data": 0.5}, "data", 0.5),
        ("std_msgs/msg/UInt8", {"data": 255}, "data", 255.0),
        ("std_msgs/msg/Char", {"data": 65}, "data", 65.0),
        ("std_msgs/msg/Int64", {"data": -(2**63)}, "data", -(2.0**63)),
        ("std_msgs/msg/UInt64", {"data": 2**64 - 1}, "data", 2.0**64),
        (JOINT_STATE, JOINTS, "position[0]", 1.0),
        (JOINT_STATE, JOINTS, "name=pole:position", 2.0),
        (JOINT_STATE, JOINTS, "name=pole:velocity", 4.0),
        ("sensor_msgs/msg/Imu", {"linear_acceleration.x": 9.81}, "linear_acceleration.x", 9.81),
        (
            "sensor_msgs/msg/Imu",
            {"orientation_covariance": [0, 1, 2, 3, 4, 5, 6, 7, 8]},
            "orientation_covariance[4]",
            4.0,
        ),
        ("sensor_msgs/msg/Temperature", {"temperature": 21.5}, "temperature", 21.5),
        ("sensor_msgs/msg/Range", {"range": 2.5}, "range", 2.5),
        ("sensor_msgs/msg/FluidPressure", {"fluid_pressure": 101325.0}, "fluid_pressure", 101325.0),
        ("std_msgs/msg/Float64MultiArray", {"data": [5.0, 6.0]}, "data[1]", 6.0),
        ("std_msgs/msg/UInt8MultiArray", {"data": [5, 6]}, "data[1]", 6.0),
    ],
)
def test_a_number_is_read(
    world: World, msgtype: str, values: dict[str, Any], text: str, value: float
) -> None:
    read = sample(world, msgtype, values, text).value
    assert type(read) is float
    assert repr(read) == repr(value)


def test_a_byte_is_a_number_without_a_sign(rclpy: World, rosbags: World) -> None:
    assert sample(rclpy, "std_msgs/msg/Byte", {"data": b"\xf7"}).value == 247.0
    assert sample(rosbags, "std_msgs/msg/Byte", {"data": -9}).value == 247.0


def test_custom_types_are_read(rosbags: World) -> None:
    assert sample(rosbags, "test_msgs/msg/HeaderValue", {"value": 3.0}, "value").value == 3.0
    nested = rosbags.new("test_msgs/msg/Nested")
    nested.readings = [
        rosbags.new("test_msgs/msg/StampData", {"data": number}) for number in (4.0, 5.0)
    ]
    nested.joints = rosbags.new(JOINT_STATE, JOINTS)
    data = rosbags.serialized(nested)
    for text, value in {
        "readings[0].data": 4.0,
        "readings[1].data": 5.0,
        "joints.name=cart:position": 1.0,
    }.items():
        codec = ScalarCodec(rosbags.types, "test_msgs/msg/Nested", text)
        assert codec.sample(data, RECEIVED_NS) == Sample(RECEIVED_NS, value)
    with pytest.raises(MessageError, match="readings has 2 elements in this message"):
        ScalarCodec(rosbags.types, "test_msgs/msg/Nested", "readings[2].data").sample(data, 0)


@pytest.mark.parametrize("name", ["tiny", "small", "raw", "letter", "wide", "widest", "single"])
@pytest.mark.parametrize("rest", ["", "four"])
def test_any_number_is_found_wherever_it_lies(rosbags: World, name: str, rest: str) -> None:
    values = {name: 7, "names": [rest], "fixed": [1, 2, 3], "bounded": [4], "whole": [5, 6]}
    assert sample(rosbags, "test_msgs/msg/Numbers", values, name).value == 7.0
    for text, value in {"fixed[2]": 3.0, "bounded[0]": 4.0, "whole[1]": 6.0}.items():
        assert sample(rosbags, "test_msgs/msg/Numbers", values, text).value == value


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("position[2]", r"position has 2 elements in this message"),
        ("effort[0]", r"effort has 0 elements in this message"),
        ("name=wheel:position", r"'wheel' is not in name \['cart', 'pole'\]"),
        ("name=pole:effort", r"effort has 0 elements in this message"),
    ],
)
def test_a_number_that_one_message_lacks_is_an_error_of_that_message(
    world: World, text: str, problem: str
) -> None:
    with pytest.raises(MessageError, match=problem):
        sample(world, JOINT_STATE, JOINTS, text)


TYPES = (
    "diagnostic_msgs/msg/DiagnosticArray",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "rcl_interfaces/msg/ParameterEvent",
    "sensor_msgs/msg/BatteryState",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "sensor_msgs/msg/PointCloud2",
    "sensor_msgs/msg/Range",
    "shape_msgs/msg/SolidPrimitive",
    "std_msgs/msg/Float64MultiArray",
)


OTHER_ENDIAN = pytest.mark.slow("the same numbers the other way round")


@pytest.mark.parametrize(
    ("type_name", "big_endian"),
    [
        *((each, False) for each in TYPES),
        *((each, True) for each in TYPES[:4]),
        *(pytest.param(each, True, marks=OTHER_ENDIAN) for each in TYPES[4:]),
    ],
)
def test_every_number_of_any_message_is_the_one_that_others_read(
    rclpy: World, rosbags: World, type_name: str, big_endian: bool
) -> None:
    generator = random.Random(type_name)
    for _ in range(10):
        message = rclpy.filled(type_name, generator)
        data = serialize_message(message)
        if big_endian:
            read = decoded(BagMessage("", type_name, 0, data))
            data = bytes(STORE.serialize_cdr(read, type_name, little_endian=False))
        for path, value in rclpy.numbers(message):
            for types in (InstalledTypes(), rosbags.types):
                codec = ScalarCodec(types, type_name, path)
                assert codec.sample(data, 0).value == value, path
                if "stamp." in path:
                    continue
                changed = codec.template(data).filled(5.0, STAMP_NS)
                assert codec.sample(changed, STAMP_NS) == Sample(STAMP_NS, 5.0), path
                assert len(changed) == len(data)


def result(codec: ScalarCodec, data: bytes) -> str:
    """What a codec makes of a message, errors included."""
    try:
        return repr(codec.sample(data, RECEIVED_NS))
    except MessageError as error:
        return f"{type(error).__name__}: {error}"


@given(
    st.sampled_from(["position[1]", "name=pole:position", "header.stamp.nanosec"]),
    st.lists(
        st.tuples(st.integers(0, 2), st.integers(0, 119), st.integers(0, 255), st.integers(0, 2)),
        max_size=12,
    ),
)
def test_what_was_read_before_changes_nothing(
    field: str, changes: list[tuple[int, int, int, int]]
) -> None:
    types, kind = InstalledTypes(), load_message_class(JOINT_STATE)
    whole = [
        serialize_message(kind(name=names, position=[1.0, 2.0], effort=efforts))
        for names, efforts in (
            (["cart", "pole"], []),
            (["pole", "cart"], [5.0]),
            (["car", "poles"], [5.0]),
        )
    ]
    codec = ScalarCodec(types, JOINT_STATE, field)
    for which, at, octet, cut in changes:
        for data in (whole[which], whole[which]):
            changed = bytearray(data)
            changed[at % len(data)] = octet
            for each in (data, bytes(changed), data[: len(data) - cut]):
                fresh = ScalarCodec(types, JOINT_STATE, field)
                assert result(codec, each) == result(fresh, each)


@given(st.floats(), st.integers(-(2**31) * 10**9, 2**31 * 10**9 - 1))
def test_a_template_is_filled_and_the_rest_stays(value: float, stamp_ns: int) -> None:
    kind = load_message_class(POINT)
    message = kind()
    message.header.frame_id, message.point.x, message.point.y = "pole", 1.0, 2.0
    codec = ScalarCodec(InstalledTypes(), POINT)
    data = serialize_message(message)
    filled = codec.template(data).filled(value, stamp_ns)
    assert repr(codec.sample(filled, 0)) == repr(Sample(stamp_ns, value))
    read = deserialize_message(filled, kind)
    assert (read.header.frame_id, read.point.y, repr(read.point.x)) == ("pole", 2.0, repr(value))


@pytest.mark.parametrize("frame", ["", "pole", "kétté"])
def test_the_frame_is_read(world: World, frame: str) -> None:
    data = world.data(POINT, {"header.frame_id": frame})
    assert ScalarCodec(world.types, POINT).frame(data) == frame


NUMBERS = {"uint8": "UInt8", "int8": "Int8", "int64": "Int64", "float32": "Float32"}


def filled(number: str, value: float) -> Any:
    """A message of one number, with another number in it."""
    msgtype = f"std_msgs/msg/{NUMBERS[number]}"
    codec = ScalarCodec(InstalledTypes(), msgtype)
    data = codec.template(default_message(InstalledTypes(), msgtype)).filled(value, 0)
    return deserialize_message(data, load_message_class(msgtype)).data


@pytest.mark.parametrize(
    ("number", "value", "written"),
    [
        ("uint8", 2.4, 2),
        ("uint8", 2.6, 3),
        ("uint8", 255.4, 255),
        ("int8", -128.0, -128),
        ("int64", 2.0**62, 2**62),
        ("float32", 0.1, 0.10000000149011612),
    ],
)
def test_a_field_takes_the_nearest_number(number: str, value: float, written: float) -> None:
    assert filled(number, value) == written


@pytest.mark.parametrize(
    ("number", "value"),
    [
        ("uint8", 256.0),
        ("uint8", -1.0),
        ("int8", 127.6),
        ("int64", 2.0**63),
        ("int8", math.nan),
        ("int8", math.inf),
        ("float32", 1e39),
    ],
)
def test_a_value_that_a_field_cannot_hold_is_refused(number: str, value: float) -> None:
    with pytest.raises(MessageError, match=rf"'data' is of type {number}, .* does not fit"):
        filled(number, value)


@pytest.mark.parametrize("stamp_ns", [2**31 * 10**9, -(2**31) * 10**9 - 1])
def test_a_stamp_that_does_not_fit_is_refused(world: World, stamp_ns: int) -> None:
    template = ScalarCodec(world.types, POINT).template(default_message(world.types, POINT))
    with pytest.raises(MessageError, match="does not fit into 32-bit seconds"):
        template.filled(0.0, stamp_ns)


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", r"begins with b'', not as CDR"),
        (b"\0\1", r"unpack_from requires"),
        (b"\0\3\0\0" + bytes(40), r"begins with b'\\x00\\x03\\x00\\x00', not as CDR"),
        (b"\0\1\0\0" + b"\xff" * 40, r"bytes too few|unpack_from requires"),
        (b"\0\1\0\0" + bytes(32), r"8 bytes too few|unpack_from requires"),
        (b"\0\1\0\0" + bytes(8) + b"\1\0\0\0" + bytes(32), r"4 bytes too many"),
    ],
)
def test_what_is_no_message_of_the_type_is_an_error(data: bytes, problem: str) -> None:
    codec = ScalarCodec(InstalledTypes(), POINT)
    with pytest.raises(MessageError, match=problem):
        codec.sample(data, 0)


def test_counts_beyond_the_message_end_at_once(rosbags: World) -> None:
    codec = ScalarCodec(rosbags.types, "test_msgs/msg/Nested", "readings[3000000000].data")
    with pytest.raises(MessageError, match="a message is not a test_msgs/msg/Nested"):
        codec.sample(b"\0\1\0\0" + b"\xff" * 40, 0)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"text": FieldType("wstring")}, "fields of type wstring are not supported"),
        ({"again": FieldType("a_msgs/msg/A")}, "contains itself"),
    ],
)
def test_a_type_that_cannot_be_read_is_refused(fields: dict[str, FieldType], problem: str) -> None:
    types = Described({"a_msgs/msg/A": fields | {"data": FieldType("float64")}})
    with pytest.raises(MessageError, match=problem):
        ScalarCodec(types, "a_msgs/msg/A", "data")
