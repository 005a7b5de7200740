# SPDX-License-Identifier: Apache-2.0
"""Type names, and the classes that they name."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from geometry_msgs.msg import PointStamped

from fuzzy_fusion_ros.messages import load_message_class, normalise_type_name
from fuzzy_fusion_ros.messages.type_names import installed_type_names
from fuzzy_fusion_ros.parameters.errors import MessageError


@pytest.fixture
def _installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", sys.prefix)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("geometry_msgs/msg/PointStamped", "geometry_msgs/msg/PointStamped"),
        ("geometry_msgs/PointStamped", "geometry_msgs/msg/PointStamped"),
        (" std_msgs/Float64 ", "std_msgs/msg/Float64"),
        ("a1_b/msg/T2_x", "a1_b/msg/T2_x"),
    ],
)
def test_the_short_and_the_full_form_name_the_same(text: str, name: str) -> None:
    assert normalise_type_name(text) == name


@pytest.mark.parametrize(
    "text",
    [
        "",
        "PointStamped",
        "geometry_msgs",
        "geometry_msgs/",
        "/PointStamped",
        "geometry_msgs/msg/",
        "geometry_msgs/srv/PointStamped",
        "geometry_msgs/msg/pointStamped",
        "geometry_msgs/msg/Point Stamped",
        "geometry_msgs.msg.PointStamped",
        "../msg/PointStamped",
        "a/b/c/D",
    ],
)
def test_a_malformed_name_is_refused_with_the_form_that_is_expected(text: str) -> None:
    with pytest.raises(MessageError, match=r"is malformed: give package/msg/Type") as refusal:
        normalise_type_name(text)
    assert repr(text) in str(refusal.value)


def test_the_class_of_an_installed_type_is_found() -> None:
    assert load_message_class("geometry_msgs/PointStamped") is PointStamped


@pytest.mark.usefixtures("_installed")
@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("geometry_msgs/msg/PointStampt", "did you mean geometry_msgs/msg/PointStamped"),
        ("std_msgs/msg/Temperature", "did you mean sensor_msgs/msg/Temperature"),
        ("no_msgs/msg/Float64", r"did you mean std_msgs/msg/Float64, .*std_msgs/msg/Float32"),
        ("no_msgs/msg/Qqqqqqqqqqqqqqqqqqq", "install its package and source the workspace"),
    ],
)
def test_a_type_that_is_not_installed_brings_similar_ones(name: str, hint: str) -> None:
    with pytest.raises(MessageError, match=rf"'{name}' is not installed: {hint}"):
        load_message_class(name)


@pytest.mark.usefixtures("_installed")
def test_installed_types_are_those_of_the_ament_index() -> None:
    names = installed_type_names()
    assert names == sorted(names)
    assert "sensor_msgs/msg/JointState" in names
    assert not [name for name in names if "/srv/" in name]


def test_without_an_ament_index_the_advice_is_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(MessageError, match="install its package and source the workspace"):
        load_message_class("geometry_msgs/msg/PointStampt")


def test_a_package_that_does_not_import_is_told_from_one_that_is_not_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "broken_msgs" / "msg"
    package.mkdir(parents=True)
    (package / "__init__.py").write_text("import there_is_no_such_module\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    with pytest.raises(MessageError, match=r"'broken_msgs' cannot be imported: .*there_is_no_such"):
        load_message_class("broken_msgs/msg/Float64")


def test_what_is_no_message_class_is_not_loaded() -> None:
    with pytest.raises(MessageError, match="is not installed"):
        load_message_class("geometry_msgs/msg/Metaclass_Point")
