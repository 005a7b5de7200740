# SPDX-License-Identifier: Apache-2.0
"""Where messages say how sure a number is, and that it is not known."""

from __future__ import annotations

import math

import pytest
from messages.worlds import World

from fuzzy_fusion_ros.core.aggregator import Aggregate, FiringStrengths
from fuzzy_fusion_ros.core.estimator import FUSED, Estimate, initial_state
from fuzzy_fusion_ros.core.gate import NO_PREDICTION
from fuzzy_fusion_ros.messages import ScalarCodec, default_message, resolve_field
from fuzzy_fusion_ros.messages.outputs import EstimateMessages, EstimateSource
from fuzzy_fusion_ros.messages.variances import NO_INFORMATION, NONE, Elements, variance_of
from fuzzy_fusion_ros.online.verdict import Fused, Together
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import EstimateParameters, Parameters

IMU, ODOMETRY, FIX = "sensor_msgs/msg/Imu", "nav_msgs/msg/Odometry", "sensor_msgs/msg/NavSatFix"
AGGREGATE = Aggregate(0.0, 0.0, 0.0, FiringStrengths(0.0, 0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("msgtype", "field", "path"),
    [
        ("sensor_msgs/msg/Temperature", "temperature", "variance"),
        ("sensor_msgs/msg/FluidPressure", "altitude(fluid_pressure)", "variance"),
        ("sensor_msgs/msg/Range", "range", "variance"),
        (IMU, "angular_velocity.z", "angular_velocity_covariance[8]"),
        (IMU, "yaw(orientation)", "orientation_covariance[8]"),
        (IMU, "roll(orientation)", "orientation_covariance[0]"),
        (IMU, "linear_acceleration.y", "linear_acceleration_covariance[4]"),
        (FIX, "altitude", "position_covariance[8]"),
        (FIX, "latitude", "position_covariance[4]"),
        (ODOMETRY, "twist.twist.linear.x", "twist.covariance[0]"),
        (ODOMETRY, "pose.pose.position.z", "pose.covariance[14]"),
        (ODOMETRY, "yaw(pose.pose.orientation)", "pose.covariance[35]"),
        (
            "geometry_msgs/msg/PoseWithCovarianceStamped",
            "pose.pose.position.x",
            "pose.covariance[0]",
        ),
    ],
)
def test_the_variance_of_a_number(world: World, msgtype: str, field: str, path: str) -> None:
    found = variance_of(world.types, msgtype, resolve_field(world.types, msgtype, field))
    assert found.path == path
    assert path in found.unknown


@pytest.mark.parametrize(
    ("msgtype", "field"),
    [
        ("geometry_msgs/msg/PointStamped", "point.x"),
        ("sensor_msgs/msg/JointState", "position[0]"),
        ("std_msgs/msg/Float64", "data"),
        ("geometry_msgs/msg/TwistStamped", "twist.linear.x"),
        ("geometry_msgs/msg/PoseArray", "poses[0].position.x"),
    ],
)
def test_types_that_do_not_tell(world: World, msgtype: str, field: str) -> None:
    assert variance_of(world.types, msgtype, resolve_field(world.types, msgtype, field)) == NONE


def fused(message: bytes, deviation: float, value: float = 0.25) -> Together:
    estimate = Estimate(FUSED, value, AGGREGATE, NO_PREDICTION, False, deviation)
    return Together(7, {"": Fused(7, estimate, initial_state(Parameters()), message)})


def made(world: World, codec: ScalarCodec, variance_field: str = "") -> EstimateMessages:
    parameters = EstimateParameters(variance_field=variance_field)
    return EstimateMessages(world.types, {"": EstimateSource(parameters, codec)})


def test_the_variance_of_s2_is_never_passed_on(world: World) -> None:
    codec = ScalarCodec(world.types, ODOMETRY, "twist.twist.angular.z")
    s2 = world.data(ODOMETRY, {"twist.covariance": [1.0 + k for k in range(36)]})
    data = made(world, codec).message(fused(s2, 0.5))
    assert codec.sample(data, 0).value == 0.25
    for k in range(36):
        element = ScalarCodec(world.types, ODOMETRY, f"twist.covariance[{k}]")
        is_ours = k // 6 == 5 or k % 6 == 5
        expected = NO_INFORMATION if k == 35 else 0.0 if is_ours else 1.0 + k
        assert element.sample(data, 0).value == expected


@pytest.mark.parametrize("reverse", [False, True])
def test_the_variance_of_one_channel_does_not_touch_that_of_another_group(
    world: World, reverse: bool
) -> None:
    """A course in the plane has one of the position, a yaw one of the orientation."""
    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    fields = ["yaw(pose.pose.orientation)", "atan2(pose.pose.position.y, pose.pose.position.x)"]
    codecs = {field: ScalarCodec(world.types, kind, field) for field in fields}
    s2 = world.data(kind, {"pose.covariance": [1.0 + k for k in range(36)]})
    sources = {
        name: EstimateSource(EstimateParameters(), codecs[field])
        for name, field in zip("ab", reversed(fields) if reverse else fields, strict=True)
    }
    (one,) = fused(s2, 0.0).fused.values()
    data = EstimateMessages(world.types, sources).message(Together(7, {"a": one, "b": one}))
    for k in range(36):
        row, column = divmod(k, 6)
        is_ours = {row, column} & {0, 1, 2, 5}
        expected = 0.0 if is_ours else 1.0 + k
        if row == column and is_ours:
            expected = NO_INFORMATION
        assert ScalarCodec(world.types, kind, f"pose.covariance[{k}]").value(data) == expected


def test_zeros_say_that_a_covariance_is_not_known(world: World) -> None:
    codec = ScalarCodec(world.types, FIX, "altitude")
    s2 = world.data(
        FIX,
        {"position_covariance": [4.0] * 8 + [9.0], "position_covariance_type": 2},
    )
    data = made(world, codec).message(fused(s2, 0.5))
    for path in ("position_covariance[0]", "position_covariance[8]", "position_covariance_type"):
        assert ScalarCodec(world.types, FIX, path).sample(data, 0).value == 0.0


def test_our_variance_is_written_where_it_is_named_and_known(world: World) -> None:
    kind = "sensor_msgs/msg/Temperature"
    codec = ScalarCodec(world.types, kind, "", 0.5, 0.0)
    variance = ScalarCodec(world.types, kind, "variance")
    s2 = world.data(kind, {"variance": 9.0})
    messages = made(world, codec, "variance")
    for deviation, expected in ((0.5, 1.0), (0.0, 0.0), (0.25, 0.25)):
        data = messages.message(fused(s2, deviation))
        assert variance.sample(data, 0).value == expected
        assert codec.sample(data, 0).value == 0.25


@pytest.mark.parametrize("scale", [1.0, -0.001])
def test_the_variance_of_an_altitude_is_one_of_the_pressure(world: World, scale: float) -> None:
    """2 m are about 24 Pa at sea level."""
    kind = "sensor_msgs/msg/FluidPressure"
    codec = ScalarCodec(world.types, kind, "altitude(fluid_pressure)", scale, 0.0)
    s2 = world.data(kind, {"fluid_pressure": 101325.0, "variance": 9.0})
    data = made(world, codec, "variance").message(fused(s2, 2.0 * abs(scale), 0.5 * scale))
    variance = ScalarCodec(world.types, kind, "variance").value(data)
    assert math.sqrt(variance) == pytest.approx(2.0 * 12.01, rel=1e-3)


def test_an_angle_of_a_vector_leaves_no_variance_of_s2(world: World) -> None:
    """It is written into all three numbers."""
    kind = "geometry_msgs/msg/AccelWithCovarianceStamped"
    codec = ScalarCodec(world.types, kind, "roll(accel.accel.linear)")
    s2 = world.data(kind, {"accel.accel.linear.z": 9.81, "accel.covariance": [2.0] * 36})
    data = made(world, codec).message(fused(s2, 0.5))
    for k in (0, 7, 14):
        element = ScalarCodec(world.types, kind, f"accel.covariance[{k}]")
        assert element.value(data) == NO_INFORMATION


@pytest.mark.parametrize("deviation", [0.5, 0.0])
def test_variances_of_other_angles_stay_where_ours_is_known(world: World, deviation: float) -> None:
    """In sensor_msgs, zeros are unknown only as a whole: beside ours they would be certainty."""
    codec = ScalarCodec(world.types, IMU, "yaw(orientation)")
    s2 = world.data(
        IMU, {"orientation.w": 1.0, "orientation_covariance": [1.0 + k for k in range(9)]}
    )
    messages = made(world, codec, "orientation_covariance[8]")
    data = messages.message(fused(s2, deviation))
    found = [
        ScalarCodec(world.types, IMU, f"orientation_covariance[{k}]").value(data) for k in range(9)
    ]
    assert found == ([1.0, 2.0, 0.0, 4.0, 5.0, 0.0, 0.0, 0.0, 0.25] if deviation else [0.0] * 9)
    again = messages.message(fused(s2, 0.5 - deviation))
    assert (ScalarCodec(world.types, IMU, "orientation_covariance[0]").value(again) == 1.0) != bool(
        deviation
    )


def test_a_field_for_the_variance_that_is_not_there_is_refused(world: World) -> None:
    codec = ScalarCodec(world.types, "sensor_msgs/msg/Temperature")
    with pytest.raises(MessageError, match="no field 'covariance'"):
        made(world, codec, "covariance[0]")


def test_a_name_with_a_dot_is_no_fault(world: World) -> None:
    joints = "sensor_msgs/msg/JointState"
    field = resolve_field(world.types, joints, "name=left.wheel:position")
    assert variance_of(world.types, joints, field) == NONE


def test_a_number_that_does_not_fit_is_an_error_of_ours(world: World) -> None:
    kind = "sensor_msgs/msg/Range"
    elements = Elements(world.types, kind, ["max_range"])  # a float32
    with pytest.raises(MessageError, match="does not fit"):
        elements.written(default_message(world.types, kind, "base_link"), [1e300])
