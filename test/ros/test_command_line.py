# SPDX-License-Identifier: Apache-2.0
"""The executables of the nodes: help, refusals in one line, exit statuses."""

from __future__ import annotations

from pathlib import Path

import pytest

from fuzzy_fusion_ros.nodes.parameters import PendulumParameters, SubscriberParameters
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import Group, descriptors
from fuzzy_fusion_ros.ros.command_line import split
from fuzzy_fusion_ros.testing import Harness

EXECUTABLES: dict[str, type[Group]] = {
    "fusion_node": Parameters,
    "pendulum_node": PendulumParameters,
    "sensor_subscriber": SubscriberParameters,
}


@pytest.mark.parametrize("executable", EXECUTABLES)
def test_help_names_every_parameter(harness: Harness, executable: str) -> None:
    process = harness.start(executable, "--help")
    assert (process.wait(), process.stderr) == (0, "")
    assert process.stdout.startswith(f"usage: fuzzy-fusion {executable}")
    for name, _, _ in descriptors(EXECUTABLES[executable]):
        assert f"\n  {name} {{" in process.stdout


REFUSED = {
    "an unknown parameter": (
        ["--ros-args", "-p", "gate.tolerence:=1.0"],
        "parameter gate.tolerence: unknown; did you mean gate.tolerance?",
    ),
    "a missing file": (
        ["--params", "/nowhere/p.yaml"],
        "parameter file '/nowhere/p.yaml': cannot be read: No",
    ),
    "a missing file, ROS's way": (
        ["--ros-args", "--params-file", "/nowhere/p.yaml"],
        "parameter file '/nowhere/p.yaml': cannot be read: No such file",
    ),
    "no file": (["--ros-args", "--params-file"], "invalid ROS arguments: failed to initialize"),
    "half an override": (["--ros-args", "-p"], "invalid ROS arguments: failed to initialize"),
    "an unknown ROS argument": (["--ros-args", "--zzz"], "invalid ROS arguments: "),
    "an unknown type": (
        ["--ros-args", "-p", "s1.type:=std_msgs/msg/Flot64"],
        "message type 'std_msgs/msg/Flot64' is not installed: did you mean std_msgs/msg/Float64?",
    ),
    "a bag that exists": (
        ["--ros-args", "-p", "record:=/tmp"],
        "bag '/tmp' exists: choose another",
    ),
    "a topic of no name": (["--ros-args", "-r", "s1:=//"], "invalid ROS arguments: "),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_used_is_said_in_one_line(harness: Harness, name: str) -> None:
    arguments, problem = REFUSED[name]
    process = harness.start("fusion_node", *arguments)
    assert process.wait() == 2
    (line,) = process.stderr.splitlines()
    assert line.startswith(f"fusion_node: {problem}")
    assert process.stdout == ""


def test_a_stray_argument_is_refused(harness: Harness) -> None:
    process = harness.start("fusion_node", "params.yaml")
    assert process.wait() == 2
    assert "unrecognized arguments: params.yaml" in process.stderr


def test_a_run_that_finds_nobody_ends_with_2_and_one_line(harness: Harness) -> None:
    process = harness.start("pendulum_node", "--ros-args", "-p", "timeout:=0.2")
    assert process.wait() == 2
    (line,) = process.stderr.splitlines()
    assert line.startswith("pendulum_node: nobody subscribes to /s1, nobody subscribes to /s2")


def test_a_file_may_be_given_without_ros_args_and_p_goes_on_top(
    harness: Harness, tmp_path: Path
) -> None:
    path = tmp_path / "pendulum.yaml"
    path.write_text("pendulum_node:\n  ros__parameters:\n    feedback: truth\n    duration: 7.0\n")
    process = harness.start(
        "pendulum_node", "--params-file", str(path), "--ros-args", "-p", "duration:=0.1"
    )
    assert process.wait() == 0, process.stderr
    assert "the pendulum was balanced for 0.1 s" in process.stderr


def test_arguments_are_split_as_ros_does() -> None:
    line = ["--params", "a", "--ros-args", "-p", "x:=1", "--", "-h", "--ros-args", "-r", "a:=b"]
    assert split(line) == (["--params", "a", "-h"], ["-p", "x:=1", "-r", "a:=b"])
