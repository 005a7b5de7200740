# SPDX-License-Identifier: Apache-2.0
"""Parameters: described, refused with their names, changed all or none."""

from __future__ import annotations

import gc
from pathlib import Path
from typing import Any

import pytest
from nodes.watching import WARN, Diagnostics, Log
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import DescribeParameters, SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter

from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.nodes.sensor_subscriber import SensorSubscriber
from fuzzy_fusion_ros.parameters.errors import FusionError, ParameterError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import descriptors, flatten
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.testing import Harness

REFUSED_AT_START: dict[str, tuple[dict[str, Any], str]] = {
    "unknown, with a hint": ({"gate.tolerence": 1.0}, "gate.tolerence: unknown; did you mean gate"),
    "unknown, without one": ({"zzz": 1.0}, "zzz: unknown; expected one of s1.type"),
    "out of range": (
        {"gate.tolerance": -1.0},
        r"gate.tolerance: got -1.0, expected a number from 0 to 1e\+09 \(signal\)",
    ),
    "not finite": ({"gate.tolerance": float("nan")}, "gate.tolerance: got nan, expected a number"),
    "text for a number": ({"gate.tolerance": "x"}, "gate.tolerance: got 'x', expected a number"),
    "number for a switch": ({"predictor.enabled": 1}, "predictor.enabled: got 1, expected true or"),
    "half an integer": (
        {"predictor.samples": 7.5},
        "predictor.samples: got 7.5, expected an integ",
    ),
    "a list": ({"gate.tolerance": [1.0, 2.0]}, "gate.tolerance: got .*, expected a number"),
    "no choice": ({"trigger": "s2"}, "trigger: got 's2', expected one of s1, pair, timer"),
    "a word of YAML": (
        {"s1.field": True},
        "s1.field: got True, expected a string: quote words like",
    ),
    "a combination": (
        {"aggregator.rate.small": 5.0, "aggregator.rate.large": 4.0},
        "aggregator.rate.small: got 5.0, expected less than large 4.0",
    ),
    "of ROS itself": ({"use_sim_time": "yes"}, "use_sim_time: .* expecting type 'BOOL'"),
    "no QoS policy": (
        {"qos_overrides./s1.subscription.reliability": "firm"},
        "qos_overrides of s1: Unexpected QoS override for policy `reliability`: `firm`",
    ),
    "no QoS depth": (
        {"qos_overrides./s1.subscription.depth": "deep"},
        "qos_overrides of s1: .*expecting type 'INTEGER'",
    ),
    "QoS of no topic of ours": (
        {"qos_overrides./s3.subscription.depth": 3},
        "/s3.subscription.depth: unknown; expected one of qos_overrides./s1.subscription.history",
    ),
}


@pytest.mark.parametrize("name", REFUSED_AT_START)
def test_what_cannot_be_used_refuses_the_start(harness: Harness, name: str) -> None:
    given, problem = REFUSED_AT_START[name]
    with pytest.raises(ParameterError, match=problem):
        harness.add(FusionNode, given)


@pytest.mark.parametrize(
    "given",
    [{"use_sim_time": "yes"}, {"zzz": 1}, {"s1.type": "a/B"}, {"estimate.type": "std_msgs/String"}],
    ids=lambda given: next(iter(given)),
)
def test_a_refused_node_leaves_nothing_behind(
    harness: Harness, log: Log, tmp_path: Path, given: dict[str, Any]
) -> None:
    """Not even its name, whose log topic would go with it when it is collected."""
    with pytest.raises(FusionError) as refusal:
        harness.add(FusionNode, {**given, "record": str(tmp_path / "bag")})
    node = harness.fusion_node()
    del refusal
    gc.collect()
    node.log.info("still heard")
    log.wait_for("still heard")


@pytest.mark.parametrize("node_class", [FusionNode, PendulumNode, SensorSubscriber])
def test_every_parameter_is_declared_and_described(
    harness: Harness, node_class: type[ConfiguredNode[Any]]
) -> None:
    node = harness.add(node_class)
    wanted = flatten(node.parameters)
    response = harness.call(
        DescribeParameters,
        f"{node.get_name()}/describe_parameters",
        DescribeParameters.Request(names=list(wanted)),
    )
    described = {each.name: each for each in response.descriptors}
    assert described.keys() == wanted.keys()
    for name, descriptor, _ in descriptors(type(node.parameters)):
        message = described[name]
        assert descriptor.text in message.description
        assert descriptor.unit in message.description
        assert message.additional_constraints == descriptor.range
        assert not message.dynamic_typing
        if descriptor.kind in (int, float):
            (limits,) = message.integer_range or message.floating_point_range
            assert (limits.from_value, limits.to_value) == (descriptor.low, descriptor.high)
        assert node.get_parameter(name).value == wanted[name]


def test_integers_are_taken_for_numbers_at_start_and_later(harness: Harness) -> None:
    node = harness.add(FusionNode, {"gate.tolerance": 2})
    assert node.get_parameter("gate.tolerance").value == 2.0
    (result,) = set_remotely(harness, {"gate.tolerance": 3})
    assert result.successful
    assert node.parameters.gate.tolerance == 3.0
    assert node.get_parameter("gate.tolerance").type_ == Parameter.Type.DOUBLE


def messages(values: dict[str, Any]) -> list[ParameterMessage]:
    return [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]


def set_remotely(harness: Harness, values: dict[str, Any]) -> list[SetParametersResult]:
    """Set parameters one by one, as `ros2 param set` does."""
    request = SetParameters.Request(parameters=messages(values))
    results: list[SetParametersResult] = harness.call(
        SetParameters, "fusion_node/set_parameters", request
    ).results
    return results


def set_at_once(harness: Harness, values: dict[str, Any]) -> SetParametersResult:
    """Set parameters all or none, over the service."""
    request = SetParametersAtomically.Request(parameters=messages(values))
    return harness.call(
        SetParametersAtomically, "fusion_node/set_parameters_atomically", request
    ).result


def test_a_set_takes_effect_at_the_next_sample(harness: Harness) -> None:
    harness.fusion_node()
    feed = harness.feed()
    before = feed(0.0, s1=1.0, s2=2.0)
    result = set_at_once(
        harness,
        {
            "aggregator.difference.small": 10.0,
            "aggregator.difference.large": 20.0,
            "aggregator.weight.small": 1.0,
        },
    )
    assert result.successful
    after = feed(0.01, s1=1.0)
    assert (before, after) == (2.0, 1.0)


REFUSED_LATER: dict[str, tuple[dict[str, Any], str]] = {
    "out of range": (
        {"gate.tolerance": -1.0},
        "parameter gate.tolerance: got -1.0, expected a num",
    ),
    "not finite": ({"gate.tolerance": float("inf")}, "parameter gate.tolerance: got inf, expected"),
    "another type": (
        {"gate.tolerance": "x"},
        "parameter gate.tolerance: got 'x', expected a numbe",
    ),
    "unknown": ({"gate.width": 1.0}, "parameter gate.width: unknown; "),
    "fixed": (
        {"trigger": "pair"},
        "parameter trigger: got 'pair', but it is read at start-up only: restart the node",
    ),
    "deleted": ({"gate.tolerance": None}, "parameter gate.tolerance: got None, expected a number"),
    "a combination": (
        {"aggregator.rate.small": 2e6, "aggregator.rate.large": 1e6},
        "parameter aggregator.rate.small: got 2000000.0, expected less than large",
    ),
    "one of several": (
        {"gate.tolerance": 0.5, "predictor.rules": 3, "aggregator.weight.large": 1.5},
        "parameter aggregator.weight.large: got 1.5, expected a number from 0 to 1",
    ),
}


@pytest.mark.parametrize("name", REFUSED_LATER)
def test_a_refused_set_says_why_and_changes_nothing(harness: Harness, name: str) -> None:
    node = harness.fusion_node()
    values, problem = REFUSED_LATER[name]
    before = node.parameters
    result = set_at_once(harness, values)
    assert not result.successful
    assert result.reason.startswith(problem)
    assert node.parameters is before
    stored = {name: node.get_parameter(name).value for name in flatten(before)}
    assert stored == flatten(before)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("by", [1e6, 1e-6])
def test_break_points_move_one_by_one_in_any_order(harness: Harness, by: float, order: int) -> None:
    node = harness.fusion_node()
    moved = {"aggregator.rate.small": by, "gate.tolerance": 0.5, "aggregator.rate.large": 2.0 * by}
    results = set_remotely(harness, dict(list(moved.items())[::order]))
    assert [result.successful for result in results] == [True, True, True]
    rate = node.parameters.aggregator.rate
    assert (rate.small, rate.large, node.parameters.gate.tolerance) == (by, 2.0 * by, 0.5)
    assert node.held == {}


def test_half_a_pair_is_held_said_and_leaves_others_alone(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    node = harness.fusion_node()
    before = node.parameters.aggregator.rate
    (result,) = set_remotely(harness, {"aggregator.rate.small": 1e6})
    assert result.successful
    assert result.reason.startswith("not in use yet: parameter aggregator.rate.small: got 1000000")
    assert set_remotely(harness, {"gate.tolerance": 0.5})[0].successful
    assert node.parameters.aggregator.rate == before
    assert node.parameters.gate.tolerance == 0.5
    text = "not in use until their partners are set as well: aggregator.rate.small = 1000000.0"
    assert diagnostics.saying("fusion_node: fusion", text).level == WARN
    (refused,) = set_remotely(harness, {"aggregator.rate.large": -1.0})
    assert not refused.successful
    assert set_remotely(harness, {"aggregator.rate.small": before.small})[0].successful
    assert node.held == {}


def test_parameters_of_ros_itself_are_left_alone(harness: Harness) -> None:
    node = harness.fusion_node({"qos_overrides./s1.subscription.depth": 3})
    assert node.get_parameter("qos_overrides./s1.subscription.depth").value == 3
    assert set_at_once(harness, {"use_sim_time": True, "gate.tolerance": 0.5}).successful
    assert node.parameters.gate.tolerance == 0.5
    assert node.get_parameter("use_sim_time").value is True


def test_a_change_of_the_predictors_size_starts_it_anew(harness: Harness) -> None:
    harness.fusion_node({"predictor.enabled": True, "predictor.samples": 5})
    feed = harness.feed()
    for k in range(30):
        feed(0.01 * k, s1=0.01 * k, s2=0.01 * k)
    assert set_at_once(harness, {"predictor.samples": 9, "predictor.rules": 3}).successful
    for k in range(30, 60):
        assert abs(feed(0.01 * k, s1=0.01 * k, s2=0.01 * k) - 0.01 * k) < 0.2


FILE = """\
{owner}:
  ros__parameters:
    gate:
      tolerance: 3
    predictor.samples: 0x10
    aggregator.rate_time_constant: 1e-2
    predictor: {{enabled: on}}
"""


@pytest.mark.parametrize(
    "owner", ["fusion_node", "/fusion_node", "/**", "/**/fusion_node", "/*", "'*'"]
)
def test_a_file_for_this_node_is_taken(harness: Harness, tmp_path: Path, owner: str) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(FILE.format(owner=owner))
    parameters = harness.add(FusionNode, parameter_file=path).parameters
    assert parameters.gate.tolerance == 3.0
    assert parameters.predictor.samples == 16
    assert parameters.predictor.enabled
    assert parameters.aggregator.rate_time_constant == 0.01


@pytest.mark.parametrize("owner", ["other_node", "/ns/fusion_node", "/*/fusion_node", "/**/other"])
def test_a_file_for_another_node_is_refused(harness: Harness, tmp_path: Path, owner: str) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(FILE.format(owner=owner))
    with pytest.raises(ParameterError, match=r"it has no entry for /fusion_node, only for /"):
        harness.add(FusionNode, parameter_file=path)


def test_a_namespace_and_a_name_are_matched(harness: Harness, tmp_path: Path) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text(FILE.format(owner="/robot/fuser"))
    arguments = ("-r", "__ns:=/robot", "-r", "__node:=fuser")
    node = harness.add(FusionNode, parameter_file=path, arguments=arguments)
    assert node.parameters.gate.tolerance == 3.0


def test_an_unknown_name_in_a_file_is_refused(harness: Harness, tmp_path: Path) -> None:
    path = tmp_path / "parameters.yaml"
    path.write_text("/**:\n  ros__parameters:\n    frequency: 30.0\n")
    with pytest.raises(ParameterError, match=r"parameter frequency: unknown"):
        harness.add(FusionNode, parameter_file=path)


def test_the_example_files_are_taken(harness: Harness) -> None:
    config = Path(__file__).parents[2] / "config"
    node = harness.add(FusionNode, parameter_file=config / "fusion_node.yaml")
    assert node.parameters == Parameters(), "run test/nodes/write_config.py"
    harness.remove(node)
    harness.add(FusionNode, parameter_file=config / "pendulum.yaml")
    harness.add(PendulumNode, parameter_file=config / "pendulum.yaml")
