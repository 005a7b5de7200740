# SPDX-License-Identifier: Apache-2.0
"""Definitions of installed types."""

from __future__ import annotations

import json
import os
import struct
import sys
from pathlib import Path

import pytest
from bag.making import POINT

from fuzzy_fusion_ros.bag import BagTypes, BagWriter, Definition, Topic, open_bag
from fuzzy_fusion_ros.bag.installed import installed_definition
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.parameters.errors import BagError


@pytest.fixture
def prefix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An ament prefix with two packages of messages, before the real ones."""
    messages = {
        "one_msgs/msg/Outer": (
            "# A comment with no_msgs/Type name\n"
            "std_msgs/Header header  # another\n"
            "one_msgs/Inner[] inner\n"
            "Inner single\n"
            "two_msgs/msg/Deep[<=3] deep\n"
            "string<=5 name 'x'\n"
            "float64[2] pair [1.0, 2.0]\n"
            "uint8 KIND=3\n"
            "bool yes true\n"
        ),
        "one_msgs/msg/Inner": "float64 value\ntwo_msgs/Deep deep\n",
        "two_msgs/msg/Deep": "int32 number\n",
        "two_msgs/msg/Broken": "no_msgs/Nothing nothing\n",
        "two_msgs/msg/Loop": "two_msgs/Loop[] loop\n",
    }
    for name, text in messages.items():
        path = tmp_path / "share" / f"{name}.msg"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (tmp_path / "share/two_msgs/msg/Deep.json").write_text(
        json.dumps({"type_hashes": [{"type_name": "two_msgs/msg/Deep", "hash_string": "RIHS01_1"}]})
    )
    real = os.environ.get("AMENT_PREFIX_PATH", sys.prefix)
    monkeypatch.setenv("AMENT_PREFIX_PATH", os.pathsep.join(["", str(tmp_path), real]))
    return tmp_path


@pytest.mark.usefixtures("prefix")
def test_a_definition_carries_those_of_nested_types() -> None:
    definition = installed_definition("one_msgs/msg/Outer")
    assert definition.encoding == "ros2msg"
    parts = definition.text.split("=" * 80 + "\n")
    heads = [part.partition("\n")[0] for part in parts[1:]]
    assert parts[0].startswith("# A comment")
    assert sorted(heads) == [
        "MSG: builtin_interfaces/Time",
        "MSG: one_msgs/Inner",
        "MSG: std_msgs/Header",
        "MSG: two_msgs/Deep",
    ]
    types = BagTypes([Topic("/x", "one_msgs/msg/Outer", definition=definition)])
    assert types.problems == []
    assert list(types.fields("one_msgs/msg/Outer")) == [
        *("header", "inner", "single", "deep", "name", "pair", "yes")
    ]


@pytest.mark.usefixtures("prefix")
def test_the_hash_is_that_of_the_installed_description() -> None:
    assert installed_definition("two_msgs/msg/Deep") == Definition(
        "ros2msg", "int32 number\n", "RIHS01_1"
    )
    assert installed_definition("one_msgs/msg/Inner").digest == ""
    assert installed_definition(POINT).digest.startswith("RIHS01_")


@pytest.mark.usefixtures("prefix")
def test_a_type_that_contains_itself_ends() -> None:
    assert installed_definition("two_msgs/msg/Loop").text == "two_msgs/Loop[] loop\n"


@pytest.mark.usefixtures("prefix")
@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("no_msgs/msg/Nothing", "'no_msgs/msg/Nothing' has no definition: source the package"),
        (
            "two_msgs/msg/Broken",
            r"'two_msgs/msg/Broken' has no definition \(it contains 'no_msgs/msg/Nothing'",
        ),
    ],
)
def test_what_is_not_installed_is_named(name: str, reason: str) -> None:
    with pytest.raises(BagError, match=reason):
        installed_definition(name)


@pytest.mark.usefixtures("prefix")
def test_an_installed_type_can_be_recorded_and_read(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as bag:
        bag.write("/x", "one_msgs/msg/Inner", 1, struct.pack("<4sdi", b"\0\1\0\0", 0.5, 7))
    with open_bag(tmp_path / "bag") as read:
        (message,) = read.messages()
        codec = ScalarCodec(read.types, "one_msgs/msg/Inner", "deep.number")
        assert codec.sample(message.data, 0).value == 7.0
        assert read.problems == []
