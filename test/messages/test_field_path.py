"""Field paths, on messages of rclpy and of rosbags alike."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages.worlds import Rclpy, Rosbags, World

from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.messages import FieldPath
from fuzzy_fusion_ros.messages.field_path import Step

WORLDS: dict[str, World] = {"rclpy": Rclpy(), "rosbags": Rosbags()}
JOINTS = {"name": ["cart", "pole"], "position": [1.0, 2.0], "velocity": [3.0, 4.0]}


@pytest.fixture(params=WORLDS)
def world(request: pytest.FixtureRequest) -> World:
    return WORLDS[request.param]


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("data", [Step("data")]),
        ("point.x", [Step("point"), Step("x")]),
        ("position[0]", [Step("position", element=0)]),
        ("position[007]", [Step("position", element=7)]),
        ("a.b[2].c", [Step("a"), Step("b", element=2), Step("c")]),
        ("name=pole:position", [Step("position", names="name", key="pole")]),
        ("a.name=pole:position", [Step("a"), Step("position", names="name", key="pole")]),
        ("a[1].n=k:v.x", [Step("a", element=1), Step("v", names="n", key="k"), Step("x")]),
        ("name=arm.joint/1:position", [Step("position", names="name", key="arm.joint/1")]),
        ("name=a:b:position", [Step("position", names="name", key="a:b")]),
        ("name=x=y:position", [Step("position", names="name", key="x=y")]),
        ("name= :position", [Step("position", names="name", key=" ")]),
    ],
)
def test_a_path_is_parsed_into_its_steps(text: str, steps: list[Step]) -> None:
    assert FieldPath(text).steps == tuple(steps)


@pytest.mark.parametrize(
    "text",
    [
        "",
        ".",
        "point.",
        ".x",
        "point..x",
        "position[-1]",
        "position[]",
        "position[a]",
        "position[1",
        "position[1][2]",
        "position[1.0]",
        "0",
        "_private",
        "point x",
        "name=pole",
        "name=:position",
        "=pole:position",
        "name=pole:position[0]",
        "point()",
    ],
)
def test_what_is_no_path_is_refused_with_examples(text: str) -> None:
    with pytest.raises(MessageError, match=r"is not understood; write for example 'data'"):
        FieldPath(text)


@given(st.text())
def test_any_text_is_a_path_or_refused(text: str) -> None:
    try:
        path = FieldPath(text)
    except MessageError:
        return
    assert path.steps


@pytest.mark.parametrize(
    ("msgtype", "values", "text", "value"),
    [
        ("geometry_msgs/msg/PointStamped", {"point.x": 1.5}, "point.x", 1.5),
        ("geometry_msgs/msg/PointStamped", {"point.z": -2.5}, "point.z", -2.5),
        ("geometry_msgs/msg/PointStamped", {"header.stamp.sec": 7}, "header.stamp.sec", 7.0),
        ("std_msgs/msg/Float64", {"data": 0.1}, "data", 0.1),
        ("std_msgs/msg/Float32", {"data": 0.5}, "data", 0.5),
        ("std_msgs/msg/UInt8", {"data": 255}, "data", 255.0),
        ("std_msgs/msg/Char", {"data": 65}, "data", 65.0),
        ("std_msgs/msg/Int64", {"data": -(2**63)}, "data", -(2.0**63)),
        ("std_msgs/msg/UInt64", {"data": 2**64 - 1}, "data", 2.0**64),
        ("sensor_msgs/msg/JointState", JOINTS, "position[0]", 1.0),
        ("sensor_msgs/msg/JointState", JOINTS, "name=pole:position", 2.0),
        ("sensor_msgs/msg/JointState", JOINTS, "name=pole:velocity", 4.0),
        (
            "sensor_msgs/msg/Imu",
            {"linear_acceleration.x": 9.81},
            "linear_acceleration.x",
            9.81,
        ),
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
        ("std_msgs/msg/Float64", {"data": math.inf}, "data", math.inf),
        ("std_msgs/msg/Float64", {"data": -0.0}, "data", -0.0),
    ],
)
def test_a_number_is_read(
    world: World, msgtype: str, values: dict[str, Any], text: str, value: float
) -> None:
    read = FieldPath(text).read(world.new(msgtype, values))
    assert type(read) is float
    assert read == value


def test_nan_passes_through(world: World) -> None:
    message = world.new("std_msgs/msg/Float64", {"data": math.nan})
    assert math.isnan(FieldPath("data").read(message))


def test_a_byte_is_a_number_in_either_form() -> None:
    assert FieldPath("data").read(WORLDS["rclpy"].new("std_msgs/msg/Byte", {"data": b"\x07"})) == 7
    assert FieldPath("data").read(WORLDS["rosbags"].new("std_msgs/msg/Byte", {"data": 7})) == 7


def test_custom_types_are_read() -> None:
    world = WORLDS["rosbags"]
    message = world.new("test_msgs/msg/HeaderValue", {"value": 3.0})
    assert FieldPath("value").read(message) == 3.0
    message = world.new("test_msgs/msg/Nested")
    message.readings = [world.new("test_msgs/msg/StampData", {"data": 4.0})]
    message.joints = world.new("sensor_msgs/msg/JointState", JOINTS)
    assert FieldPath("readings[0].data").read(message) == 4.0
    assert FieldPath("joints.name=cart:position").read(message) == 1.0


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("position[2]", r"position has 2 elements in this message"),
        ("effort[0]", r"effort has 0 elements in this message"),
        ("name=wheel:position", r"'wheel' is not in name \['cart', 'pole'\]"),
        ("names=pole:position", r"'pole' is not in names None"),
        ("name=pole:effort", r"effort has 0 elements in this message"),
        ("positions[0]", r"sensor_msgs/msg/JointState has no field 'positions'"),
        ("header.time", r"std_msgs/msg/Header has no field 'time'"),
        ("header[0]", r"header has no elements in this message"),
        ("name", r"holds a list, no number"),
        ("name[0]", r"holds a str, no number"),
        ("header", r"holds a Header, no number|holds a std_msgs__msg__Header, no number"),
        ("position", r"holds a (array|ndarray), no number"),
        ("position[0].x", r"float(64)? has no field 'x'"),
    ],
)
def test_a_number_that_one_message_lacks_is_an_error_of_that_message(
    world: World, text: str, problem: str
) -> None:
    message = world.new("sensor_msgs/msg/JointState", JOINTS)
    with pytest.raises(MessageError, match=problem):
        FieldPath(text).read(message)


def test_a_bool_is_no_number(world: World) -> None:
    with pytest.raises(MessageError, match="holds a bool, no number"):
        FieldPath("data").read(world.new("std_msgs/msg/Bool", {"data": True}))


def test_numbers_of_numpy_are_numbers_but_its_bools_are_none() -> None:
    message = WORLDS["rosbags"].new("std_msgs/msg/Float64", {"data": np.float32(0.5)})
    assert FieldPath("data").read(message) == 0.5
    message.data = np.int16(3)
    assert FieldPath("data").read(message) == 3.0
    message.data = np.bool_(True)
    with pytest.raises(MessageError, match="holds a bool"):
        FieldPath("data").read(message)


def test_paths_are_equal_by_text_and_survive_pickling() -> None:
    path = FieldPath("name=pole:position", "float32")
    again = pickle.loads(pickle.dumps(path))
    assert again == path
    assert again != FieldPath("name=pole:position")
    assert hash(again) == hash(path)
    message = WORLDS["rosbags"].new("sensor_msgs/msg/JointState", JOINTS)
    assert again.read(message) == 2.0
