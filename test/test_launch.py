# SPDX-License-Identifier: Apache-2.0
"""The launch files: both say the same, and what they start works."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple
from xml.etree import ElementTree

import pytest

from fuzzy_fusion_ros.testing import Feed, Harness

ROOT = Path(__file__).resolve().parents[1]
LAUNCH = ROOT / "launch"
DEFAULTS = ROOT / "config" / "fusion_node.yaml"


class Call(NamedTuple):
    """What a launch file in Python has made, by the name of its class."""

    name: str
    positional: tuple[Any, ...]
    named: dict[str, Any]


class StandIn(ModuleType):
    """A module of launch, which is not on PyPI; its classes keep what they are given."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *positional, **named: Call(name, positional, named)


@pytest.fixture
def from_python(monkeypatch: pytest.MonkeyPatch) -> list[Call]:
    """What fusion.launch.py describes."""
    for name in ("launch", "launch_ros"):
        for module in (name, f"{name}.actions", f"{name}.substitutions"):
            monkeypatch.setitem(sys.modules, module, StandIn(module))
    described = runpy.run_path(str(LAUNCH / "fusion.launch.py"))["generate_launch_description"]()
    return list(described.positional[0])


@pytest.fixture
def from_xml() -> ElementTree.Element:
    """What fusion.launch.xml describes."""
    return ElementTree.parse(LAUNCH / "fusion.launch.xml").getroot()


def variable(name: str) -> Call:
    return Call("LaunchConfiguration", (name,), {})


def test_both_take_the_same_arguments(
    from_python: list[Call], from_xml: ElementTree.Element
) -> None:
    arguments = {each.positional[0]: each.named for each in from_python[:-1]}
    written = {each.get("name", ""): each for each in from_xml.findall("arg")}
    assert list(arguments) == list(written)
    assert list(arguments) == ["params_file", "namespace", "s1", "s2", "estimate", "use_sim_time"]
    for name, values in arguments.items():
        assert values["description"] == written[name].get("description")
        if name != "params_file":
            assert values["default_value"] == written[name].get("default")
    (places,) = arguments["params_file"]["default_value"].positional
    assert places[0] == Call("FindPackageShare", ("fuzzy_fusion_ros",), {})
    default = "/".join(["$(find-pkg-share fuzzy_fusion_ros)", *places[1:]])
    assert written["params_file"].get("default") == default
    assert (ROOT / Path(*places[1:])) == DEFAULTS


def test_a_file_that_includes_them_gives_each_its_own_scope(from_xml: ElementTree.Element) -> None:
    """Without a group, launch passes the arguments of an include on to the next."""
    page = (ROOT / "docs" / "fusion_node.md").read_text()
    (example,) = re.findall(r"```xml\n(.*?)```", page, re.DOTALL)
    places = list(ElementTree.fromstring(example))
    assert [place.tag for place in places] == ["group", "group"]
    known = {each.get("name") for each in from_xml.findall("arg")}
    for (included,) in places:
        path = str(included.get("file")).removeprefix("$(find-pkg-share fuzzy_fusion_ros)/")
        assert ROOT / path == LAUNCH / "fusion.launch.xml"
        assert {each.get("name") for each in included} <= known


def test_both_start_the_same_node(from_python: list[Call], from_xml: ElementTree.Element) -> None:
    node, (written,) = from_python[-1].named, from_xml.findall("node")
    for key, name in (("package", "pkg"), ("executable", "exec"), ("name", "name")):
        assert node[key] == written.get(name)
    assert node["namespace"] == variable("namespace")
    assert written.get("namespace") == "$(var namespace)"
    assert node["ros_arguments"] == ["--params-file", variable("params_file")]
    assert written.get("ros_args") == "--params-file $(var params_file)"
    assert node["parameters"] == [{"use_sim_time": variable("use_sim_time")}]
    assert [each.attrib for each in written.findall("param")] == [
        {"name": "use_sim_time", "value": "$(var use_sim_time)"},
    ]
    remaps = [(each.get("from"), each.get("to")) for each in written.findall("remap")]
    assert remaps == [(name, f"$(var {name})") for name in ("s1", "s2", "estimate")]
    assert node["remappings"] == [(name, variable(name)) for name in ("s1", "s2", "estimate")]


def started(harness: Harness, folder: Path, namespace: str, **topics: str) -> Feed:
    """Run the node with the arguments for ROS that launch makes of its own; return a feed."""
    given = folder / "launch_params"
    given.write_text("/**:\n  ros__parameters:\n    use_sim_time: false\n")
    names = {name: topics.get(name, name) for name in ("s1", "s2", "estimate")}
    remaps = {"__node": "fusion_node", "__ns": namespace, **names}
    harness.fusion_node(
        parameter_file=DEFAULTS,
        arguments=(
            *("--params-file", str(given)),
            *(word for name, to in remaps.items() for word in ("-r", f"{name}:={to}")),
        ),
    )
    absolute = {
        name: topic if topic.startswith("/") else f"{namespace}/{topic}"
        for name, topic in names.items()
    }
    return harness.feed(**absolute)


def test_two_nodes_of_one_file_do_not_disturb_each_other(harness: Harness, tmp_path: Path) -> None:
    left = started(harness, tmp_path, "/left", s1="/imu")
    right = started(harness, tmp_path, "/right", estimate="/robot/tilt")
    for k in range(5):
        assert left(0.1 * k, s1=1.0, s2=1.0) == 1.0
        assert right(0.1 * k, s1=-2.0, s2=-2.0) == -2.0
    assert (len(left.estimates), len(right.estimates)) == (5, 5)
