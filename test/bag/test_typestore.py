"""Bytes and messages: the same as rclpy's, whoever describes the type."""

from __future__ import annotations

import json
import os
import random
import struct
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag.making import BEGIN_NS, FLOAT, POINT, STORE, definition_text, float_data, point_data
from hypothesis import given
from hypothesis import strategies as st
from rclpy.serialization import deserialize_message, serialize_message
from rosbags.interfaces import Nodetype
from sensor_msgs.msg import JointState
from std_msgs.msg import Byte, ByteMultiArray, Empty, Float64MultiArray

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic, jazzy_types, serialize
from fuzzy_fusion_ros.messages import FieldType, ScalarCodec, load_message_class
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

PACKAGES = (
    "builtin_interfaces",
    "diagnostic_msgs",
    "geometry_msgs",
    "rosgraph_msgs",
    "sensor_msgs",
    "std_msgs",
    "trajectory_msgs",
)
TYPES = sorted(name for name in STORE.fielddefs if name.split("/")[0] in PACKAGES)


def number(rng: random.Random, kind: str) -> Any:
    """Return a random number that the type can hold."""
    if kind == "bool":
        return rng.random() < 0.5
    if kind == "float64":
        return rng.gauss(0.0, 1e3)
    if kind == "float32":
        return struct.unpack("<f", struct.pack("<f", rng.gauss(0.0, 1e3)))[0]
    if kind == "byte":
        return rng.randrange(-128, 128)  # what rosbags takes a byte for
    kind = {"char": "uint8"}.get(kind, kind)
    bits = int(kind.lstrip("uint"))
    return rng.randrange(2**bits) - (0 if kind.startswith("u") else 2 ** (bits - 1))


def value(rng: random.Random, described: Any) -> Any:
    """Return a random value of a field."""
    kind, what = described
    if kind == Nodetype.NAME:
        return message(rng, what)
    if kind == Nodetype.BASE:
        if what[0] == "string":
            return "".join(rng.choice("abcä漢") for _ in range(rng.randrange(9)))
        return number(rng, what[0])
    element, size = what
    count = size if kind == Nodetype.ARRAY else rng.randrange((size or 4) + 1)
    values = [value(rng, element) for _ in range(count)]
    if element[0] == Nodetype.NAME or element[1][0] == "string":
        return values
    dtype = {"byte": "int8", "char": "uint8", "bool": "bool"}.get(element[1][0], element[1][0])
    return np.array(values, dtype=dtype)


def message(rng: random.Random, msgtype: str) -> Any:
    """Return a random message of rosbags'."""
    cls = jazzy_types().message_class(msgtype)
    fields = {name: value(rng, each) for name, each in STORE.fielddefs[msgtype][1]}
    fields.pop("structure_needs_at_least_one_member", None)
    return cls(**fields)


@pytest.mark.parametrize("msgtype", TYPES)
def test_bytes_are_those_of_rclpy(msgtype: str) -> None:
    """But for what rclpy leaves to chance: the padding, and some bytes behind the message."""
    rng = random.Random(msgtype)
    cls = load_message_class(msgtype)
    for _ in range(5):
        original = message(rng, msgtype)
        data = serialize(original)
        rclpy_message = deserialize_message(data, cls)
        theirs = serialize_message(rclpy_message)
        assert serialize(rclpy_message) == data
        assert deserialize_message(serialize(rclpy_message), cls) == rclpy_message
        assert len(theirs) >= len(data)
        if msgtype != "std_msgs/msg/Empty":  # of which rclpy leaves all to chance
            assert serialize(jazzy_types().decode(msgtype, theirs)) == data


def test_a_message_without_padding_has_exactly_the_bytes_of_rclpy() -> None:
    for name, values in (("std_msgs/msg/Float64", (0.1,)), ("geometry_msgs/msg/Point", (1, 2, 3))):
        cls = jazzy_types().message_class(name)
        data = serialize(cls(*map(float, values)))
        assert serialize_message(deserialize_message(data, load_message_class(name))) == data


def test_bytes_are_what_the_standard_says() -> None:
    types = jazzy_types()
    decoded = types.decode(POINT, point_data(BEGIN_NS + 5, 0.25))
    assert (decoded.header.stamp.sec, decoded.header.stamp.nanosec) == (BEGIN_NS // 10**9, 5)
    assert (decoded.header.frame_id, decoded.point.x) == ("", 0.25)
    assert serialize(decoded) == point_data(BEGIN_NS + 5, 0.25)


@given(st.floats(), st.integers(0, 2**31 * 10**9 - 1), st.text(max_size=20))
def test_a_sample_survives_serialisation_bit_for_bit(x: float, stamp_ns: int, frame: str) -> None:
    frame = frame.replace("\0", "").encode("utf-8", "ignore").decode()
    cls = load_message_class(POINT)
    original = cls()
    original.header.stamp.sec, original.header.stamp.nanosec = divmod(stamp_ns, 10**9)
    original.header.frame_id = frame
    original.point.x = x
    data = serialize(original)
    decoded = jazzy_types().decode(POINT, data)
    sample = ScalarCodec(jazzy_types(), POINT).sample(data, 0)
    assert sample.stamp_ns == stamp_ns
    assert struct.pack("<d", sample.value) == struct.pack("<d", x)
    assert decoded.header.frame_id == frame


@pytest.mark.parametrize(
    "fields",
    [
        {},
        {"name": ["a"], "position": [1.0]},
        {"name": ["a"], "velocity": [1.0]},
        {"name": ["abcde"], "effort": [1.0]},
        {"name": ["a", "b"], "position": [1.0, 2.0], "velocity": [3.0, 4.0]},
    ],
)
def test_the_bytes_that_rclpy_leaves_behind_empty_arrays_are_no_error(
    fields: dict[str, Any],
) -> None:
    """rosbags refuses such messages."""
    original = JointState(**fields)
    decoded = jazzy_types().decode("sensor_msgs/msg/JointState", serialize_message(original))
    for name in ("position", "velocity", "effort"):
        assert list(getattr(decoded, name)) == list(getattr(original, name))
    assert decoded.name == original.name


def test_big_endian_messages_are_read() -> None:
    data = struct.pack(">4sd", b"\0\0\0\0", 0.25)
    assert jazzy_types().decode(FLOAT, data).data == 0.25


@pytest.mark.parametrize(
    ("msgtype", "data", "problem"),
    [
        (FLOAT, b"", "it begins with b'', no CDR"),
        (FLOAT, b"\0", "no CDR"),
        (FLOAT, b"\0\2\0\0" + bytes(8), r"it begins with b'\\x00\\x02\\x00\\x00', no CDR"),
        (FLOAT, b"\0\1", "a message is no std_msgs/msg/Float64: "),
        (FLOAT, float_data(1.0)[:-1], "a message is no std_msgs/msg/Float64: "),
        (FLOAT, float_data(1.0) + bytes(4), "it has 4 bytes too many"),
        (POINT, float_data(1.0), "a message is no geometry_msgs/msg/PointStamped: "),
        (FLOAT, point_data(0, 1.0), "it has 32 bytes too many"),
        (POINT, b"\0\1\0\0" + bytes(8) + b"\xff" * 40, "Invalid string length"),
    ],
)
def test_a_message_of_another_layout_is_an_error_of_that_message(
    msgtype: str, data: bytes, problem: str
) -> None:
    with pytest.raises(MessageError, match=problem):
        jazzy_types().decode(msgtype, data)


@given(st.binary(max_size=200), st.sampled_from(TYPES))
def test_any_bytes_are_a_message_or_an_error_of_it(data: bytes, msgtype: str) -> None:
    try:
        decoded = jazzy_types().decode(msgtype, b"\0\1\0\0" + data)
    except MessageError:
        return
    assert type(decoded) is jazzy_types().message_class(msgtype)


def test_up_to_three_bytes_of_padding_at_the_end_are_no_error() -> None:
    for count in range(4):
        assert jazzy_types().decode(FLOAT, float_data(1.0) + bytes(count)).data == 1.0


@pytest.mark.parametrize(
    "spoil",
    [
        lambda each: setattr(each, "data", "text"),
        lambda each: setattr(each, "data", None),
        lambda each: delattr(each, "data"),
    ],
)
def test_a_value_that_does_not_fit_is_refused(spoil: Callable[[Any], None]) -> None:
    spoilt = jazzy_types().message_class(FLOAT)(1.0)
    spoil(spoilt)
    with pytest.raises(MessageError, match="std_msgs/msg/Float64 cannot be serialised: "):
        serialize(spoilt)


def test_what_is_no_message_is_refused() -> None:
    with pytest.raises(BagError, match="'int' is neither described by the bag nor part"):
        serialize(3)


def test_bytes_of_rclpy_are_numbers_to_rosbags() -> None:
    for raw in (b"\x00", b"\x07", b"\xff"):
        data = serialize(Byte(data=raw))
        assert data == b"\0\1\0\0" + raw
        codec = ScalarCodec(jazzy_types(), "std_msgs/msg/Byte")
        assert codec.sample(data, 0).value == raw[0]
    many = ByteMultiArray(data=[b"\x01", b"\xff"])
    packed = ByteMultiArray(data=b"\x01\xff")
    assert serialize(many) == serialize(packed)
    assert deserialize_message(serialize(many), ByteMultiArray).data == [b"\x01", b"\xff"]


def test_empty_and_nested_messages_of_rclpy_are_serialised() -> None:
    assert serialize(Empty()) == b"\0\1\0\0\0"
    layout = Float64MultiArray(data=[1.0, 2.0])
    layout.layout.dim = [load_message_class("std_msgs/msg/MultiArrayDimension")(label="x", size=2)]
    again = deserialize_message(serialize(layout), Float64MultiArray)
    assert again == layout


@pytest.mark.parametrize("msgtype", TYPES)
def test_hashes_are_those_of_rosidl(msgtype: str) -> None:
    package, _, short = msgtype.split("/")
    prefixes = os.environ.get("AMENT_PREFIX_PATH", sys.prefix).split(os.pathsep)
    places = [Path(each, "share", package, "msg", f"{short}.json") for each in prefixes]
    path = next((each for each in places if each.is_file()), None)
    assert path is not None, f"{msgtype} is not installed"
    hashes = json.loads(path.read_text())["type_hashes"]
    expected = {each["type_name"]: each["hash_string"] for each in hashes}[msgtype]
    assert jazzy_types().definition(msgtype).digest == expected


def described(**texts: str) -> BagTypes:
    """Return the types of a bag that describes types so; names with __ for slashes."""
    return BagTypes(
        Topic(f"/{name}", name.replace("__", "/"), definition=Definition("ros2msg", text))
        for name, text in texts.items()
    )


def test_a_type_is_what_its_bag_says() -> None:
    """Even a type of Jazzy's: the bytes were written as the bag says."""
    types = described(std_msgs__msg__Float64="float32 data\nfloat32 extra")
    data = struct.pack("<4sff", b"\0\1\0\0", 1.5, 2.5)
    decoded = types.decode(FLOAT, data)
    assert (decoded.data, decoded.extra) == (1.5, 2.5)
    assert types.serialize(decoded) == data
    assert types.fields(FLOAT)["extra"] == FieldType("float32")
    assert jazzy_types().decode(FLOAT, float_data(2.0)).data == 2.0  # others are not touched


def test_what_contains_such_a_type_follows_it() -> None:
    text = definition_text(POINT).replace("float64 z\n", "float64 z\nfloat64 w\n")
    types = described(geometry_msgs__msg__PointStamped=text)
    decoded = types.decode(POINT, point_data(0, 1.0) + struct.pack("<d", 4.0))
    assert decoded.point.w == 4.0


def test_a_type_that_nobody_knows_is_read_as_the_bag_describes_it() -> None:
    line = "=" * 80
    text = "std_msgs/Header header\nsecret_msgs/Pair[] pairs\n"
    text += f"{line}\nMSG: secret_msgs/Pair\nfloat64 a\nfloat64 b\n"
    text += definition_text("std_msgs/msg/Header").replace(
        "builtin", f"{line}\nMSG: std_msgs/Header\nbuiltin", 1
    )
    types = described(secret_msgs__msg__Stamped=text)
    assert types.problems == []
    stamp_frame_and_count = struct.pack("<IIIxxxxI", 1, 2, 1, 1)
    data = b"\0\1\0\0" + stamp_frame_and_count + bytes(4) + struct.pack("<2d", 0.5, 1.5)
    decoded = types.decode("secret_msgs/msg/Stamped", data)
    assert (decoded.header.stamp.sec, decoded.pairs[0].b) == (1, 1.5)
    pairs = FieldType("secret_msgs/msg/Pair", True)
    assert types.fields("secret_msgs/msg/Stamped")["pairs"] == pairs


def test_idl_definitions_are_read() -> None:
    text = """
module secret_msgs { module msg {
  struct Pair { double a; double b; };
}; };
"""
    framed = "=" * 80 + "\nIDL: secret_msgs/msg/Pair\n" + text
    for each in (text, framed):
        topic = Topic("/x", "secret_msgs/msg/Pair", definition=Definition("ros2idl", each))
        types = BagTypes([topic])
        assert types.problems == []
        data = struct.pack("<4s2d", b"\0\1\0\0", 1.0, 2.0)
        assert types.decode("secret_msgs/msg/Pair", data).b == 2.0


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", ""),
        ("float64", "is not understood"),
        ("\x00\x01\x02", "is not understood"),
        ("float64 data\nfloat64 data", ""),
        ("float64 class", ""),
        ("no_msgs/Nothing data", "is not usable: no_msgs/msg/Nothing is not described"),
    ],
)
def test_a_definition_of_no_use_is_told_and_jazzys_is_used(text: str, problem: str) -> None:
    types = described(std_msgs__msg__Float64=text)
    if problem:
        assert problem in types.problems[0]
        assert types.decode(FLOAT, float_data(1.0)).data == 1.0
    else:
        with pytest.raises((MessageError, BagError)):
            types.decode(FLOAT, float_data(1.0)[:-1])


def test_an_encoding_that_nobody_reads_is_told() -> None:
    topic = Topic("/x", "secret_msgs/msg/Pair", definition=Definition("protobuf", "message"))
    types = BagTypes([topic])
    assert "encoding 'protobuf' is neither ros2msg nor ros2idl" in types.problems[0]
    with pytest.raises(BagError, match="'secret_msgs/msg/Pair' is neither described"):
        types.decode("secret_msgs/msg/Pair", b"\0\1\0\0")


def test_a_definition_of_another_type_is_told() -> None:
    text = "float64 data\n" + "=" * 80 + "\nMSG: secret_msgs/Other\nfloat64 a"
    topic = Topic("/x", "secret msgs Pair", definition=Definition("ros2msg", text))
    assert BagTypes([topic]).problems != []


def test_a_type_that_contains_itself_is_refused() -> None:
    types = described(secret_msgs__msg__Endless="secret_msgs/Endless inner\nfloat64 value")
    with pytest.raises(BagError, match="'secret_msgs/msg/Endless' is described badly"):
        types.decode("secret_msgs/msg/Endless", b"\0\1\0\0" + bytes(64))


def test_a_type_that_is_not_known_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    types = BagTypes()
    for ask in (types.message_class, lambda name: types.decode(name, b"\0\1\0\0")):
        with pytest.raises(BagError, match=r"'secret_msgs/msg/Pair' is neither .* copied but not"):
            ask("secret_msgs/msg/Pair")
    with pytest.raises(BagError, match="'secret_msgs/msg/Pair' has no definition"):
        types.definition("secret_msgs/msg/Pair")


@given(st.text(max_size=100))
def test_any_definition_is_taken_or_told(text: str) -> None:
    for encoding in ("ros2msg", "ros2idl"):
        topic = Topic("/x", "secret_msgs/msg/Pair", definition=Definition(encoding, text))
        types = BagTypes([topic])
        try:
            types.decode("secret_msgs/msg/Pair", b"\0\1\0\0")
        except (BagError, MessageError):
            continue
