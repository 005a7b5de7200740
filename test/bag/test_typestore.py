# SPDX-License-Identifier: Apache-2.0
"""Message types: what a bag says of them, what Jazzy does, and what is installed."""

from __future__ import annotations

import gc
import json
import os
import struct
import sys
import tracemalloc
from pathlib import Path

import pytest
from bag.making import (
    FLOAT,
    POINT,
    STORE,
    Channel,
    definition_text,
    float_data,
    point_data,
    write_channels,
)
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import get_types_from_msg

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic, definitions, jazzy_types, open_bag
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import FieldType, InstalledTypes, ScalarCodec
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
PAIR = "secret_msgs/msg/Pair"
PAIR_DATA = struct.pack("<4s2d", b"\0\1\0\0", 1.0, 2.0)


@pytest.mark.parametrize("msgtype", TYPES)
def test_types_are_those_of_rclpy(msgtype: str) -> None:
    if msgtype != "std_msgs/msg/Empty":  # of which only rosbags shows the filler
        assert jazzy_types().fields(msgtype) == InstalledTypes().fields(msgtype)


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


def value(types: BagTypes, msgtype: str, field: str, data: bytes) -> float:
    """Return the number at a path of a message."""
    return ScalarCodec(types, msgtype, field).sample(data, 0).value


def test_a_type_is_what_its_bag_says() -> None:
    """Even a type of Jazzy's: the bytes were written as the bag says."""
    types = described(std_msgs__msg__Float64="float32 data\nfloat32 extra")
    data = struct.pack("<4sff", b"\0\1\0\0", 1.5, 2.5)
    assert value(types, FLOAT, "data", data) == 1.5
    assert value(types, FLOAT, "extra", data) == 2.5
    assert value(jazzy_types(), FLOAT, "data", float_data(2.0)) == 2.0  # not affected


def test_what_contains_such_a_type_follows_it() -> None:
    text = definition_text(POINT).replace("float64 z\n", "float64 z\nfloat64 w\n")
    types = described(geometry_msgs__msg__PointStamped=text)
    assert value(types, POINT, "point.w", point_data(0, 1.0) + struct.pack("<d", 4.0)) == 4.0


def test_a_type_that_nobody_knows_is_read_as_the_bag_describes_it() -> None:
    line = "=" * 80
    text = "std_msgs/Header header\nsecret_msgs/Pair[] pairs\n"
    text += f"{line}\nMSG: secret_msgs/Pair\nfloat64 a\nfloat64 b\n"
    text += definition_text("std_msgs/msg/Header").replace(
        "builtin", f"{line}\nMSG: std_msgs/Header\nbuiltin", 1
    )
    types = described(secret_msgs__msg__Stamped=text)
    assert types.fields("secret_msgs/msg/Stamped")["pairs"] == FieldType(PAIR, True)
    assert types.problems == []
    stamp_frame_and_count = struct.pack("<IIIxxxxI", 1, 2, 1, 1)
    data = b"\0\1\0\0" + stamp_frame_and_count + bytes(4) + struct.pack("<2d", 0.5, 1.5)
    codec = ScalarCodec(types, "secret_msgs/msg/Stamped", "pairs[0].b")
    assert codec.sample(data, 0) == Sample(1_000_000_002, 1.5)


def test_idl_definitions_are_read() -> None:
    text = """
module secret_msgs { module msg {
  struct Pair { double a; double b; };
}; };
"""
    framed = "=" * 80 + f"\nIDL: {PAIR}\n" + text
    for each in (text, framed):
        types = BagTypes([Topic("/x", PAIR, definition=Definition("ros2idl", each))])
        assert value(types, PAIR, "b", PAIR_DATA) == 2.0
        assert types.problems == []


@pytest.mark.parametrize("text", ["float64", "\x00\x01\x02", "float64 1data"])
def test_a_definition_of_no_use_is_reported_and_jazzys_is_used(text: str) -> None:
    types = described(std_msgs__msg__Float64=text)
    assert value(types, FLOAT, "data", float_data(1.0)) == 1.0
    (problem,) = types.problems
    assert problem.startswith("the definition of std_msgs/msg/Float64 cannot be parsed: ")


def test_a_nested_type_that_nobody_describes_is_named() -> None:
    types = described(secret_msgs__msg__Pair="no_msgs/Nothing data\nfloat64 value")
    with pytest.raises(MessageError, match="'no_msgs/msg/Nothing' is neither described by"):
        ScalarCodec(types, PAIR, "value")


def test_fields_may_have_names_that_python_reserves() -> None:
    types = described(secret_msgs__msg__Pair="float64 class\nfloat64 def")
    assert value(types, PAIR, "def", PAIR_DATA) == 2.0


def test_an_encoding_that_nobody_reads_is_reported() -> None:
    types = BagTypes([Topic("/x", PAIR, definition=Definition("protobuf", "message"))])
    with pytest.raises(MessageError, match="encoding 'protobuf' is neither"):
        types.fields(PAIR)
    assert "encoding 'protobuf' is neither ros2msg nor ros2idl" in types.problems[0]


def test_a_definition_of_another_type_is_reported() -> None:
    text = "module other_msgs { module msg { struct Other { double a; }; }; };"
    types = BagTypes([Topic("/x", PAIR, definition=Definition("ros2idl", text))])
    with pytest.raises(MessageError, match="is neither described"):
        types.fields(PAIR)
    assert types.problems == [f"the definition of {PAIR} describes other types instead"]


def test_a_type_that_contains_itself_is_refused() -> None:
    types = described(secret_msgs__msg__Endless="secret_msgs/Endless inner\nfloat64 value")
    with pytest.raises(MessageError, match="contains itself"):
        ScalarCodec(types, "secret_msgs/msg/Endless", "value")


def test_a_type_that_is_not_known_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(
        MessageError, match=f"'{PAIR}' is neither described by the bag nor installed"
    ):
        BagTypes().fields(PAIR)
    with pytest.raises(BagError, match=f"'{PAIR}' has no definition"):
        BagTypes().definition(PAIR)


def test_definitions_are_parsed_when_they_are_asked_for() -> None:
    """Of 60 topics two are read, and what is wrong with the others is nobody's concern."""
    types = described(secret_msgs__msg__Broken="float64", secret_msgs__msg__Pair="float64 a")
    types.fields(PAIR)
    assert types.problems == []


@given(st.text(max_size=100))
def test_any_definition_is_taken_or_refused(text: str) -> None:
    for encoding in ("ros2msg", "ros2idl"):
        types = BagTypes([Topic("/x", PAIR, definition=Definition(encoding, text))])
        try:
            ScalarCodec(types, PAIR).sample(PAIR_DATA, 0)
        except MessageError:
            continue


def bags_of(text: str, bags: int) -> list[BagTypes]:
    """Return the types of bags that describe a type in the same words."""
    return [described(secret_msgs__msg__Pair=text) for _ in range(bags)]


def test_bags_with_the_same_definitions_parse_them_once(monkeypatch: pytest.MonkeyPatch) -> None:
    parsed: list[str] = []
    text = "float64 first_of_many\n"

    def get(text: str, name: str) -> object:
        parsed.append(name)
        return get_types_from_msg(text, name)

    monkeypatch.setattr(definitions, "get_types_from_msg", get)
    fields = [types.fields(PAIR) for types in bags_of(text, 10)]
    assert [list(each) for each in fields] == [["first_of_many"]] * 10
    assert parsed == [PAIR]


def test_each_bag_reports_its_own_problems(tmp_path: Path) -> None:
    text = definition_text(FLOAT) + "\nfloat64"
    channel = Channel("/x", [(1, float_data(1.0))], "cdr", FLOAT, "ros2msg", text)
    for name in ("first", "second"):
        with open_bag(write_channels(tmp_path / f"{name}.mcap", [channel])) as bag:
            assert bag.problems == []
            bag.types.fields(FLOAT)
            assert len(bag.problems) == 1
            assert bag.problems[0].startswith(f"the definition of {FLOAT} cannot be")


def text_of(characters: int, number: int) -> str:
    """Return a definition of about that many characters, different for each number."""
    line = "float64 value_{:06}_{:06}\n"
    return "".join(line.format(number, k) for k in range(characters // len(line.format(0, 0))))


def kept_of(texts: list[str]) -> int:
    """Return the bytes that stay when bags with these definitions are gone."""
    tracemalloc.start()
    for text in texts:
        (types,) = bags_of(text, 1)
        types.fields(PAIR)
        del types
    gc.collect()
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return kept


def test_large_definitions_are_not_kept() -> None:
    definitions._parsed.cache_clear()
    assert kept_of([text_of(17_000, number) for number in range(4)]) < 100_000
    assert definitions._parsed.cache_info().currsize == 0


def test_few_definitions_are_kept_and_each_is_small() -> None:
    """Though each bag describes other types: 64 definitions, which take at most 10 MB."""
    definitions._parsed.cache_clear()
    largest = kept_of([text_of(16_000, 0)])
    assert definitions._parsed.cache_info().currsize == 1
    assert 64 * largest < 10_000_000
    kept_of([text_of(100, number) for number in range(80)])
    assert definitions._parsed.cache_info().currsize == 64
