# SPDX-License-Identifier: Apache-2.0
"""Bags of other kinds than ours: read where they can be, else what they are is named."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    STEP_NS,
    Channel,
    definition_text,
    float_data,
    point_data,
    points,
    write_bag,
    write_by_rosbags,
    write_channels,
)
from rosbags.rosbag1 import Writer as Ros1Writer
from rosbags.rosbag2 import StoragePlugin
from rosbags.typesys import Stores, get_typestore

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic, open_bag
from fuzzy_fusion_ros.bag.installed import SEPARATOR, installed_definition
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.type_names import installed_type_names
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

STAMPS_NS = [BEGIN_NS + at * STEP_NS for at in range(5)]
PLAIN = [(ns, point_data(ns, 0.5)) for ns in STAMPS_NS]


def encapsulated(kind: int) -> list[tuple[int, bytes]]:
    """Return messages that claim to be serialised in another way."""
    return [(ns, bytes([0, kind]) + data[2:]) for ns, data in PLAIN]


READ = "only 'cdr' can be read"
DESCRIBED = "only 'ros2msg' and 'ros2idl' can be read"


@pytest.mark.parametrize(
    ("channel", "problem"),
    [
        (Channel("/s1", PLAIN, "json", POINT, "jsonschema", "{}"), f"as 'json', {READ}"),
        (Channel("/s1", PLAIN, "ros1", POINT, "ros1msg", "float64 x"), f"as 'ros1', {READ}"),
        (Channel("/s1", PLAIN, "protobuf", "a.B", "protobuf", "x"), f"as 'protobuf', {READ}"),
        (Channel("/s1", PLAIN, "", POINT), f"as '', {READ}"),
        (Channel("/s1", PLAIN, msgtype=None), "'cdr', but the bag does not name their type"),
        (Channel("/s1", PLAIN, "cdr", POINT, "", ""), f"{POINT} is described as '', {DESCRIBED}"),
        (Channel("/s1", PLAIN, "cdr", POINT, "unknown", ""), f"as 'unknown', {DESCRIBED}"),
        (Channel("/s1", PLAIN, "cdr", POINT, "jsonschema", "{}"), f"as 'jsonschema', {DESCRIBED}"),
        (Channel("/s1", encapsulated(7)), r"XCDR2, only plain CDR \(XCDR1\) can be read"),
        (Channel("/s1", encapsulated(11)), "XCDR2, only plain CDR"),
        (Channel("/s1", encapsulated(3)), "CDR parameter lists, only plain CDR"),
    ],
)
def test_what_cannot_be_read_is_named(tmp_path: Path, channel: Channel, problem: str) -> None:
    path = write_channels(tmp_path / "bag.mcap", [channel, Channel("/s2", PLAIN)])
    with open_bag(path) as bag:
        bag.require_readable("/s2")
        with pytest.raises(BagError, match=rf"topic /s1: its messages are .*{problem}"):
            bag.require_readable("/s1")
        assert [each.data for each in bag.messages(["/s1"])] == [data for _, data in channel[1]]


def test_a_topic_of_two_types_is_refused(tmp_path: Path) -> None:
    floats = [(ns + 1, float_data(0.5)) for ns in STAMPS_NS]
    other = Channel("/s1", floats, "cdr", FLOAT, "ros2msg", definition_text(FLOAT))
    path = write_channels(tmp_path / "bag.mcap", [Channel("/s1", PLAIN), other])
    with (
        open_bag(path) as bag,
        pytest.raises(BagError, match=f"messages are of 2 types, {POINT} and {FLOAT}"),
    ):
        bag.require_readable("/s1")


@pytest.mark.parametrize("given", ["s1", "/s1"])
@pytest.mark.parametrize("stored", ["s1", "/s1"])
def test_a_topic_is_found_with_and_without_a_leading_slash(
    tmp_path: Path, stored: str, given: str
) -> None:
    with open_bag(write_channels(tmp_path / "bag.mcap", [Channel(stored, PLAIN)])) as bag:
        assert bag.name_of(given) == stored
        assert bag.name_of("/s2") == "/s2"


def test_a_topic_keeps_its_own_spelling_where_there_are_both(tmp_path: Path) -> None:
    channels = [Channel("s1", PLAIN), Channel("/s1", PLAIN)]
    with open_bag(write_channels(tmp_path / "bag.mcap", channels)) as bag:
        assert [bag.name_of(each) for each in ("s1", "/s1")] == ["s1", "/s1"]


LEVEL = "demo_msgs/msg/Level"


def forget_definitions(path: Path) -> None:
    """Make a bag of sqlite3 as releases before Iron recorded it."""
    import sqlite3

    database = sqlite3.connect(path)
    with database:
        database.execute("DROP TABLE message_definitions")
        database.execute("UPDATE topics SET type = ?", (LEVEL,))
    database.close()


@pytest.fixture
def undescribed(tmp_path: Path) -> Path:
    """A db3 of a type that is not Jazzy's and that it does not define."""
    path = write_by_rosbags(tmp_path / "bag", points(5), StoragePlugin.SQLITE3)
    forget_definitions(path)
    return path


@pytest.mark.parametrize(
    "files",
    [
        {"msg/Level.msg": "std_msgs/Header header\nfloat64 value\nfloat64 y\nfloat64 z\n"},
        {
            "msg/Level.idl": '#include "std_msgs/msg/Header.idl"\n'
            "module demo_msgs { module msg { struct Level {\n"
            "std_msgs::msg::Header header; double value; double y; double z; }; }; };\n"
        },
    ],
    ids=["msg", "idl alone"],
)
def test_a_type_that_the_bag_does_not_define_is_the_installed_one(
    undescribed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, files: dict[str, str]
) -> None:
    for name, text in files.items():
        path = tmp_path / "prefix/share/demo_msgs" / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
    real = os.environ.get("AMENT_PREFIX_PATH", sys.prefix)
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'prefix'}{os.pathsep}{real}")
    with open_bag(undescribed) as bag:
        bag.require_readable("/s1")
        codec = ScalarCodec(bag.types, LEVEL, "value")
        values = [codec.sample(each.data, 0).value for each in bag.messages()]
    assert values == [0.5 + at for at in range(5)]


def test_a_type_that_is_not_installed_either_is_refused(undescribed: Path) -> None:
    with open_bag(undescribed) as bag, pytest.raises(MessageError) as refusal:
        ScalarCodec(bag.types, LEVEL, "value")
    assert str(refusal.value) == (
        f"message type '{LEVEL}' is neither described by the bag nor installed: "
        "source the package that defines it"
    )


@pytest.mark.parametrize("every", [10, pytest.param(1, marks=pytest.mark.slow("all of 300 files"))])
def test_installed_idl_files_are_read_as_rosbag2_stores_them(every: int) -> None:
    """With their #include lines; the fields are those of rclpy."""
    checked = 0
    for name in sorted(installed_type_names())[::every]:
        texts = idl_texts(name)
        if not texts:
            continue
        text = "\n".join(f"{SEPARATOR}IDL: {each}\n{texts[each]}" for each in texts)
        types = BagTypes([Topic("/x", name, definition=Definition("ros2idl", text))])
        fields = types.fields(name)
        assert types.problems == [], name
        if list(fields) != ["structure_needs_at_least_one_member"]:
            assert fields == InstalledTypes().fields(name)
        checked += "#include" in text
    assert checked > 50 / every


def idl_texts(name: str, texts: dict[str, str] | None = None) -> dict[str, str]:
    """Return the installed .idl files of a type and of all that it includes, by type."""
    texts = {} if texts is None else texts
    for prefix in os.environ["AMENT_PREFIX_PATH"].split(os.pathsep):
        path = Path(prefix, "share", f"{name}.idl")
        if path.is_file() and name not in texts:
            texts[name] = path.read_text(encoding="utf-8")
            for each in re.findall(r'#include "(.+)\.idl"', texts[name]):
                idl_texts(each, texts)
    return texts


def test_an_installed_type_without_msg_file_is_defined_by_its_idl(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    texts = {
        "demo_msgs/msg/Level": '#include "demo_msgs/msg/Unit.idl"\nmodule demo_msgs { module msg '
        "{ struct Level { demo_msgs::msg::Unit unit; double value; }; }; };\n",
        "demo_msgs/msg/Unit": "module demo_msgs { module msg { struct Unit { string name; }; }; };",
    }
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    for name, text in texts.items():
        path = tmp_path / "share" / f"{name}.idl"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    definition = installed_definition(LEVEL)
    assert definition.encoding == "ros2idl"
    assert definition.text.startswith(f"{SEPARATOR}IDL: {LEVEL}\n#include")
    types = BagTypes([Topic("/x", LEVEL, definition=definition)])
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    assert list(types.fields("demo_msgs/msg/Unit") if types.fields(LEVEL) else ()) == ["name"]


def ros1_bag(path: Path) -> Path:
    """Write a bag of ROS 1."""
    store = get_typestore(Stores.ROS1_NOETIC)
    with Ros1Writer(path) as writer:
        connection = writer.add_connection("/s1", FLOAT, typestore=store)
        for ns in STAMPS_NS:
            message = store.types[FLOAT](data=0.5)
            writer.write(connection, ns, store.serialize_ros1(message, FLOAT))
    return path


@pytest.mark.parametrize("name", ["run.bag", "run.dat", ""])
def test_a_bag_of_ros_1_names_the_converter(tmp_path: Path, name: str) -> None:
    """By its suffix, by its content, or alone in a directory."""
    path = ros1_bag(tmp_path / (name or "run.bag"))
    with pytest.raises(
        BagError, match=r"is a ROS 1 bag: convert it with 'rosbags-convert --src .*run"
    ):
        open_bag(path if name else tmp_path)


def rename(directory: Path, to: Sequence[str]) -> None:
    """Rename the storage files of a bag, or remove those that get no name."""
    for path, name in zip(sorted(directory.glob("*.mcap")), to, strict=True):
        if name:
            path.rename(directory / name)
        else:
            path.unlink()


def test_a_renamed_storage_file_is_read_and_reported(tmp_path: Path) -> None:
    messages = points(5)
    directory = write_bag(tmp_path / "bag", messages).parent
    rename(directory, ["run.mcap"])
    with open_bag(directory) as bag:
        assert list(bag.messages()) == messages
        assert bag.problems == [
            "bag_0.mcap: metadata.yaml lists this file, but it is missing; reading run.mcap instead"
        ]


def test_a_missing_storage_file_is_named(tmp_path: Path) -> None:
    directory = write_bag(tmp_path / "bag", points(5)).parent
    rename(directory, [""])
    with pytest.raises(BagError, match=r"metadata\.yaml lists bag_0\.mcap, but there is no"):
        open_bag(directory)
    shutil.rmtree(directory)
    directory.mkdir()
    with pytest.raises(BagError, match="it is not a rosbag2 directory"):
        open_bag(directory)
