# SPDX-License-Identifier: Apache-2.0
"""Paths checked against types, before the first message comes."""

from __future__ import annotations

import pytest
from messages.worlds import Rclpy, Rosbags, World

from fuzzy_fusion_ros.messages import FieldPath, FieldType, numeric_fields, resolve_field
from fuzzy_fusion_ros.parameters.errors import MessageError

WORLDS: dict[str, World] = {"rclpy": Rclpy(), "rosbags": Rosbags()}


@pytest.fixture(params=WORLDS)
def world(request: pytest.FixtureRequest) -> World:
    return WORLDS[request.param]


@pytest.mark.parametrize(
    ("msgtype", "text", "number"),
    [
        ("geometry_msgs/msg/PointStamped", "point.y", "float64"),
        ("geometry_msgs/PointStamped", "point.x", "float64"),
        ("geometry_msgs/msg/PointStamped", "header.stamp.nanosec", "uint32"),
        ("std_msgs/msg/Float32", "data", "float32"),
        ("std_msgs/msg/Byte", "data", "uint8"),
        ("sensor_msgs/msg/JointState", "position[12]", "float64"),
        ("sensor_msgs/msg/JointState", "name=pole:effort", "float64"),
        ("sensor_msgs/msg/Imu", "orientation_covariance[8]", "float64"),
        ("sensor_msgs/msg/MultiDOFJointState", "joint_names=a:twist.linear.x", "float64"),
        ("geometry_msgs/msg/PoseArray", "poses[3].position.z", "float64"),
        ("sensor_msgs/msg/Range", "radiation_type", "uint8"),
    ],
)
def test_a_path_to_a_number_is_accepted(world: World, msgtype: str, text: str, number: str) -> None:
    assert resolve_field(world.types, msgtype, text).paths == (FieldPath(text, number),)


@pytest.mark.parametrize(
    ("msgtype", "text"),
    [
        ("geometry_msgs/msg/PointStamped", "point.x"),
        ("geometry_msgs/msg/Vector3Stamped", "vector.x"),
        ("geometry_msgs/msg/Point", "x"),
        ("std_msgs/msg/Float64", "data"),
        ("std_msgs/msg/Float32", "data"),
        ("std_msgs/msg/Int32", "data"),
        ("sensor_msgs/msg/Temperature", "temperature"),
        ("sensor_msgs/msg/FluidPressure", "fluid_pressure"),
        ("sensor_msgs/msg/RelativeHumidity", "relative_humidity"),
        ("sensor_msgs/msg/Illuminance", "illuminance"),
        ("sensor_msgs/msg/Range", "range"),
    ],
)
def test_the_default_is_the_only_float_or_the_agreed_one(
    world: World, msgtype: str, text: str
) -> None:
    assert resolve_field(world.types, msgtype).text == text


@pytest.mark.parametrize(
    ("msgtype", "text"),
    [("test_msgs/msg/HeaderValue", "value"), ("test_msgs/msg/StampData", "data")],
)
def test_custom_types_have_defaults_too(msgtype: str, text: str) -> None:
    assert resolve_field(WORLDS["rosbags"].types, msgtype).text == text


@pytest.mark.parametrize(
    ("msgtype", "candidates"),
    [
        ("sensor_msgs/msg/Imu", "orientation.x, orientation.y"),
        ("sensor_msgs/msg/JointState", r"position\[0\], name=...:position, velocity\[0\]"),
        ("std_msgs/msg/Float64MultiArray", r"data\[0\]"),
        ("geometry_msgs/msg/Twist", "linear.x, linear.y, linear.z, angular.x"),
    ],
)
def test_without_a_clear_default_the_user_chooses(
    world: World, msgtype: str, candidates: str
) -> None:
    with pytest.raises(
        MessageError, match=rf"{msgtype} has no default field; choose one of: {candidates}"
    ):
        resolve_field(world.types, msgtype)


@pytest.mark.parametrize(
    ("msgtype", "text", "problem"),
    [
        ("geometry_msgs/msg/PointStamped", "points.x", "PointStamped has no field 'points'"),
        ("geometry_msgs/msg/PointStamped", "point.w", "Point has no field 'w'"),
        ("geometry_msgs/msg/PointStamped", "point", "Point is not a number"),
        ("geometry_msgs/msg/PointStamped", "header.frame_id", "string is not a number"),
        ("geometry_msgs/msg/PointStamped", "point.x.y", "float64 has no field 'y'"),
        ("geometry_msgs/msg/PointStamped", "point[0]", "'point' is a geometry_msgs/msg/Point"),
        ("geometry_msgs/msg/PointStamped", "point.x[0]", "'x' is a float64, not an array"),
        ("sensor_msgs/msg/JointState", "position", r"float64\[\] is a whole array"),
        ("sensor_msgs/msg/JointState", "name[0]", "string is not a number"),
        ("sensor_msgs/msg/JointState", "names=a:position", "JointState has no field 'names'"),
        ("sensor_msgs/msg/JointState", "name=a:positions", "JointState has no field 'positions'"),
        (
            "sensor_msgs/msg/JointState",
            "effort=a:position",
            r"'effort' is a float64\[\], not an array",
        ),
        ("sensor_msgs/msg/JointState", "name=a:header", "'header' is a std_msgs/msg/Header, no"),
        ("sensor_msgs/msg/Imu", "orientation_covariance[9]", "has at most 9 elements"),
        ("geometry_msgs/msg/PoseArray", "poses.position.x", r"Pose\[\] has no field 'position'"),
        ("sensor_msgs/msg/BatteryState", "present", "bool is not a number"),
    ],
)
def test_a_path_that_leads_to_no_number_is_refused_with_those_that_do(
    world: World, msgtype: str, text: str, problem: str
) -> None:
    with pytest.raises(MessageError, match=rf"{problem}.*; choose one of: ") as refusal:
        resolve_field(world.types, msgtype, text)
    assert str(refusal.value).startswith(f"field {text!r} of {msgtype}: ")


def test_a_bound_counts_as_a_size() -> None:
    with pytest.raises(MessageError, match="'bounded' has at most 2 elements"):
        resolve_field(WORLDS["rosbags"].types, "test_msgs/msg/Numbers", "bounded[2]")


@pytest.mark.parametrize("text", ["", "data"])
def test_a_type_without_any_number_is_no_use(world: World, text: str) -> None:
    with pytest.raises(MessageError, match="has no numeric field: use another type"):
        resolve_field(world.types, "std_msgs/msg/Bool", text)


def test_an_unknown_type_is_said_before_anything_else(world: World) -> None:
    with pytest.raises(MessageError, match=r"'no_msgs/msg/Nothing' is (not|neither)"):
        resolve_field(world.types, "no_msgs/msg/Nothing", "not a path")


class Described:
    """Types as a test wants them."""

    def __init__(self, **fields: str) -> None:
        self._fields = {name: FieldType(kind) for name, kind in fields.items()}

    def fields(self, type_name: str) -> dict[str, FieldType]:
        return self._fields


def test_a_long_list_of_candidates_is_cut() -> None:
    types = Described(**{f"x{at}": "float64" for at in range(30)})
    with pytest.raises(MessageError, match=r"choose one of: x0, x1, .*, x19 and 10 more$"):
        resolve_field(types, "test_msgs/msg/Long")


@pytest.mark.parametrize(
    ("msgtype", "paths"),
    [
        ("sensor_msgs/msg/Temperature", ["temperature", "variance"]),
        (
            "sensor_msgs/msg/Range",
            ["field_of_view", "min_range", "max_range", "range", "variance", "radiation_type"],
        ),
    ],
)
def test_candidates_come_floats_first_variances_last(
    world: World, msgtype: str, paths: list[str]
) -> None:
    assert numeric_fields(world.types, msgtype) == paths


@pytest.mark.parametrize(
    "msgtype",
    ["sensor_msgs/msg/Imu", "sensor_msgs/msg/JointState", "sensor_msgs/msg/BatteryState"],
)
def test_every_candidate_is_accepted(world: World, msgtype: str) -> None:
    for text in numeric_fields(world.types, msgtype):
        chosen = text.replace("...", "pole")
        assert resolve_field(world.types, msgtype, chosen).text == chosen


def test_types_that_contain_themselves_end() -> None:
    types = Described(inner="test_msgs/msg/Endless", value="float64")
    assert len(numeric_fields(types, "test_msgs/msg/Endless")) < 20
