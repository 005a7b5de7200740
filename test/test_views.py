# SPDX-License-Identifier: Apache-2.0
"""The layouts and models in config/: they are whole, and what they show is there to be seen."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.outputs import JOINTS, RULES, SENTENCE, TEXT
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.nodes.plant_topics import JOINT
from fuzzy_fusion_ros.simulation.scenario import PlantParameters
from fuzzy_fusion_ros.testing import Harness

CONFIG = Path(__file__).parents[1] / "config"


def plotjuggler_curves() -> Iterator[tuple[str, str]]:
    """Yield topic and path of each curve of the PlotJuggler layout."""
    root = ElementTree.parse(CONFIG / "plotjuggler.xml").getroot()
    for curve in root.iter("curve"):
        name = curve.attrib["name"]
        topic, _, path = name.partition("/point/")
        yield (topic, f"point.{path}") if path else _of_joint(name)


def _of_joint(name: str) -> tuple[str, str]:
    """Return topic and path of a curve of a JointState, which PlotJuggler names by its joint."""
    topic, rule, field = name.rsplit("/", 2)
    assert rule in RULES
    return topic, f"{field}[{RULES.index(rule)}]"


def foxglove_paths() -> Iterator[tuple[str, str]]:
    """Yield topic and path of each line of the Foxglove layout."""
    for name, panel in json.loads((CONFIG / "foxglove.json").read_text())["configById"].items():
        if name.startswith("Plot!"):
            for each in panel["paths"]:
                topic, _, path = each["value"].partition(".")
                yield topic, path


@pytest.fixture(scope="module")
def graph() -> dict[str, str]:
    """The topics of both nodes, and their types."""
    with Harness() as harness:
        harness.fusion_node()
        harness.add(PendulumNode)
        expected = {"/fusion_node/explanation", "/joint_states", "/diagnostics"}

        def topics() -> dict[str, str]:
            return {name: types[0] for name, types in harness.node.get_topic_names_and_types()}

        harness.spin_until(lambda: topics().keys() >= expected)
        return topics()


@pytest.mark.parametrize("layout", [plotjuggler_curves, foxglove_paths])
def test_each_line_of_a_layout_is_a_number_that_the_nodes_publish(
    layout: Callable[[], Iterator[tuple[str, str]]], graph: dict[str, str]
) -> None:
    lines = list(layout())
    shown = {topic for topic, _ in lines}
    assert shown >= {"/s1", "/s2", "/estimate", "/truth", "/fusion_node/weight"}
    for topic, path in lines:
        assert ScalarCodec(InstalledTypes(), graph[topic], path).field.text == path
    strengths = [path for topic, path in lines if graph[topic] == JOINTS]
    assert strengths == [f"position[{k}]" for k in range(len(RULES))]


def test_the_foxglove_layout_places_each_of_its_panels_once(graph: dict[str, str]) -> None:
    layout = json.loads((CONFIG / "foxglove.json").read_text())

    def panels(place: object) -> Iterator[str]:
        if isinstance(place, dict):
            yield from panels(place["first"])
            yield from panels(place["second"])
        else:
            yield str(place)

    assert sorted(panels(layout["layout"])) == sorted(layout["configById"])
    topic, _, field = layout["configById"]["RawMessages!why"]["topicPath"].partition(".")
    assert (topic, graph[topic], field) == (f"/fusion_node/{SENTENCE}", TEXT, "data")
    assert layout["configById"]["DiagnosticSummary!health"]["topicToRender"] in graph


def test_the_model_is_the_plant_and_is_moved_by_its_joint_states() -> None:
    robot = ElementTree.parse(CONFIG / "pendulum.urdf").getroot()
    (moving,) = (each for each in robot.iter("joint") if each.attrib["type"] != "fixed")
    assert moving.attrib["name"] == JOINT
    axis = moving.find("axis")
    assert axis is not None
    assert axis.attrib["xyz"] == "0 1 0"  # about y, z turns towards x: a push along x tips it back
    links = {each.attrib["name"]: each for each in robot.iter("link")}
    masses = {name: each.find("inertial/mass") for name, each in links.items()}
    pole, cart, rod = masses["pole"], masses["cart"], links["pole"].find(".//cylinder")
    assert pole is not None
    assert cart is not None
    assert rod is not None
    plant = PlantParameters()
    assert float(pole.attrib["value"]) == plant.pole_mass
    assert float(cart.attrib["value"]) == plant.cart_mass
    assert float(rod.attrib["length"]) == 2.0 * plant.half_length


def test_rviz_shows_the_model_in_one_of_its_frames() -> None:
    view = yaml.safe_load((CONFIG / "pendulum.rviz").read_text())["Visualization Manager"]
    robot = ElementTree.parse(CONFIG / "pendulum.urdf").getroot()
    assert view["Global Options"]["Fixed Frame"] in {
        each.attrib["name"] for each in robot.iter("link")
    }
    (model,) = (each for each in view["Displays"] if each["Class"].endswith("/RobotModel"))
    assert model["Description Topic"]["Value"] == "/robot_description"
