# SPDX-License-Identifier: Apache-2.0
"""The units of numbers in standard messages."""

from __future__ import annotations

import pytest
from messages.worlds import World

from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.units import RATES, signal_unit, unit_of, unit_read
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

POINT = "geometry_msgs/msg/PointStamped"
PRESSURE, RANGE = "sensor_msgs/msg/FluidPressure", "sensor_msgs/msg/Range"


@pytest.mark.parametrize(
    ("msgtype", "field", "unit"),
    [
        ("geometry_msgs/msg/PointStamped", "point.x", ""),
        ("geometry_msgs/PoseStamped", "pose.position.z", "m"),
        ("geometry_msgs/msg/Twist", "linear.x", "m/s"),
        ("geometry_msgs/msg/TwistWithCovarianceStamped", "twist.twist.angular.z", "rad/s"),
        ("geometry_msgs/msg/AccelStamped", "accel.linear.x", "m/s^2"),
        ("nav_msgs/msg/Odometry", "twist.twist.linear.x", "m/s"),
        ("nav_msgs/msg/Odometry", "pose.pose.position.x", "m"),
        ("nav_msgs/msg/Odometry", "pose.pose.orientation.w", ""),
        ("sensor_msgs/msg/FluidPressure", "fluid_pressure", "Pa"),
        ("sensor_msgs/msg/Imu", "angular_velocity.z", "rad/s"),
        ("sensor_msgs/msg/Imu", "linear_acceleration.x", "m/s^2"),
        ("sensor_msgs/msg/Imu", "linear_acceleration_covariance[0]", ""),
        ("sensor_msgs/msg/Imu", "yaw(orientation)", "rad"),
        ("sensor_msgs/msg/Imu", "pitch(linear_acceleration)", "rad"),
        ("sensor_msgs/msg/Imu", "norm(linear_acceleration)", "m/s^2"),
        ("sensor_msgs/msg/FluidPressure", "altitude(fluid_pressure)", "m"),
        ("geometry_msgs/msg/TwistStamped", "atan2(twist.linear.y, twist.linear.x)", "rad"),
        ("sensor_msgs/msg/JointState", "position[0]", ""),
        ("sensor_msgs/msg/NavSatFix", "altitude", "m"),
        ("sensor_msgs/msg/Range", "range", "m"),
        ("sensor_msgs/msg/Temperature", "temperature", "degC"),
        ("sensor_msgs/msg/Temperature", "variance", ""),
        ("some_msgs/msg/Readings", "imus[1].angular_velocity.x", "rad/s"),
        ("some_msgs/msg/Readings", "name=left:altitude", ""),
        ("std_msgs/msg/Float64", "data", ""),
    ],
)
def test_the_unit_of_a_number(msgtype: str, field: str, unit: str) -> None:
    assert unit_of(msgtype, field) == unit


def test_rates_are_per_second() -> None:
    assert all(rate.startswith(unit.removesuffix("/s")) for unit, rate in RATES.items())


@pytest.mark.parametrize(
    ("s1", "s2", "given", "unit"),
    [
        (POINT, POINT, "", ""),
        (POINT, RANGE, "", "m"),
        (RANGE, POINT, "", "m"),
        (RANGE, RANGE, "", "m"),
        (RANGE, RANGE, "ft", "ft"),
        (PRESSURE, RANGE, "m", "m"),
    ],
)
def test_the_unit_of_a_signal(rosbags: World, s1: str, s2: str, given: str, unit: str) -> None:
    codecs = [ScalarCodec(rosbags.types, each) for each in (s1, s2)]
    assert signal_unit(*codecs, replace(Parameters(), {"signal.unit": given})) == unit


def test_sensors_in_two_units_are_refused_with_both(rosbags: World) -> None:
    codecs = [ScalarCodec(rosbags.types, each) for each in (PRESSURE, RANGE)]
    with pytest.raises(MessageError, match=r"s1 is in Pa \(.*\), s2 is in m \(.*set signal.unit"):
        signal_unit(*codecs, Parameters())


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "m"), (-1.02, "m"), (100.0, ""), (0.3048, "")])
def test_a_scale_changes_the_unit(rosbags: World, scale: float, unit: str) -> None:
    assert unit_read(ScalarCodec(rosbags.types, RANGE, scale=scale)) == unit
