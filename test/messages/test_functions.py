# SPDX-License-Identifier: Apache-2.0
"""Scalars that are computed from numbers of a message, and back."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from messages.worlds import World

from fuzzy_fusion_ros.messages import ScalarCodec, computed_fields, default_message, resolve_field
from fuzzy_fusion_ros.messages.functions import (
    FUNCTIONS,
    PLAIN,
    Angles,
    Function,
    altitude_of,
    angles_of,
    pressure_of,
    quaternion_of,
    scaled,
)
from fuzzy_fusion_ros.parameters.errors import MessageError

IMU = "sensor_msgs/msg/Imu"
QUATERNION, VECTOR = 0, -1
ANGLES = st.floats(-3.1, 3.1)
PITCHES = st.floats(-1.5, 1.5)


@given(ANGLES, PITCHES, ANGLES)
def test_angles_and_quaternions_are_one_another(roll: float, pitch: float, yaw: float) -> None:
    angles = Angles(roll, pitch, yaw)
    assert angles_of(quaternion_of(angles)) == pytest.approx(angles, abs=1e-9)
    double = [2.0 * each for each in quaternion_of(angles)]
    assert angles_of(double) == pytest.approx(angles, abs=1e-9)


def test_angles_are_turns_about_z_then_y_then_x() -> None:
    turn = math.sin(0.25), math.cos(0.25)
    assert angles_of((turn[0], 0.0, 0.0, turn[1])) == pytest.approx((0.5, 0.0, 0.0))
    assert angles_of((0.0, turn[0], 0.0, turn[1])) == pytest.approx((0.0, 0.5, 0.0))
    assert angles_of((0.0, 0.0, turn[0], turn[1])) == pytest.approx((0.0, 0.0, 0.5))


@pytest.mark.parametrize("quaternion", [(0.0, 0.0, 0.0, 0.0), (math.nan, 0.0, 0.0, 1.0)])
def test_no_orientation_has_no_angles(quaternion: tuple[float, ...]) -> None:
    assert all(math.isnan(each) for each in angles_of(quaternion))


@pytest.mark.parametrize("name", Angles._fields)
@given(ANGLES, PITCHES, ANGLES, PITCHES)
def test_a_new_angle_keeps_the_other_two(
    name: str, roll: float, pitch: float, yaw: float, value: float
) -> None:
    function = FUNCTIONS[name][QUATERNION]
    before = Angles(roll, pitch, yaw)
    after = angles_of(written(function, quaternion_of(before), value))
    assert after == pytest.approx(before._replace(**{name: value}), abs=1e-9)


@pytest.mark.parametrize("pitch", [0.5 * math.pi, -0.5 * math.pi, 0.5 * math.pi - 1e-9])
@pytest.mark.parametrize("name", Angles._fields)
@given(ANGLES, ANGLES)
def test_an_orientation_straight_up_or_down_stays_as_it_is(
    pitch: float, name: str, roll: float, yaw: float
) -> None:
    """Roll and yaw turn about the same axis there: only their difference or sum is known."""
    before = quaternion_of(Angles(roll, pitch, yaw))
    read = angles_of(before)
    assert read.roll == 0.0
    assert read.pitch == pytest.approx(pitch, abs=1e-9)
    after = written(FUNCTIONS[name][QUATERNION], before, getattr(read, name))
    turned = sum(a * b for a, b in zip(before, after, strict=True))  # -1 is the same orientation
    assert abs(turned) == pytest.approx(1.0, abs=1e-12)


def written(function: Function, numbers: tuple[float, ...], value: float) -> list[float]:
    assert function.write is not None
    return list(function.write(numbers, value))


@pytest.mark.parametrize(("name", "other"), [("roll", "pitch"), ("pitch", "roll")])
@given(ANGLES, PITCHES, PITCHES)
def test_a_sensor_at_rest_measures_its_tilt(
    name: str, other: str, roll: float, pitch: float, value: float
) -> None:
    g = 9.81
    at_rest = (
        -g * math.sin(pitch),
        g * math.cos(pitch) * math.sin(roll),
        g * math.cos(pitch) * math.cos(roll),
    )
    tilt = {"roll": roll, "pitch": pitch}
    this, that = FUNCTIONS[name][VECTOR], FUNCTIONS[other][VECTOR]
    assert this.read(at_rest) == pytest.approx(tilt[name], abs=1e-9)
    after = written(this, at_rest, value)
    assert this.read(after) == pytest.approx(value, abs=1e-9)
    assert that.read(after) == pytest.approx(tilt[other], abs=1e-9)
    assert math.hypot(*after) == pytest.approx(g)


def test_no_acceleration_has_no_tilt() -> None:
    assert math.isnan(FUNCTIONS["roll"][VECTOR].read((0.0, 0.0, 0.0)))
    assert math.isnan(FUNCTIONS["pitch"][VECTOR].read((0.0, math.nan, 0.0)))


def test_size_and_direction() -> None:
    (norm,), (atan2,) = FUNCTIONS["norm"], FUNCTIONS["atan2"]
    assert norm.read((2.0, 3.0, 6.0)) == 7.0
    assert norm.write is None
    assert atan2.read((1.0, -1.0)) == pytest.approx(0.75 * math.pi)
    assert written(atan2, (3.0, 4.0), math.pi / 2) == pytest.approx([5.0, 0.0])


@pytest.mark.parametrize("legs", [(0.0, 0.0), (-0.0, 0.0), (math.inf, 1.0), (math.nan, 1.0)])
def test_what_has_no_direction_is_no_angle(legs: tuple[float, float]) -> None:
    """A receiver at rest sends zeros: 0 would be a course due east, measured well."""
    assert math.isnan(FUNCTIONS["atan2"][0].read(legs))


@pytest.mark.parametrize(
    ("pressure", "altitude"),
    [(101325.0, 0.0), (89874.6, 1000.0), (54019.9, 5000.0), (22632.0, 11000.0), (5474.9, 20000.0)],
)
def test_altitudes_are_those_of_the_icao_standard_atmosphere(
    pressure: float, altitude: float
) -> None:
    assert altitude_of(pressure) == pytest.approx(altitude, abs=0.5)
    assert pressure_of(altitude) == pytest.approx(pressure, rel=1e-4)


@given(st.floats(-1000.0, 19000.0))
def test_altitudes_are_inverted(altitude: float) -> None:
    assert altitude_of(pressure_of(altitude)) == pytest.approx(altitude, abs=1e-6)


@pytest.mark.parametrize("pressure", [0.0, -1.0, math.nan])
def test_no_pressure_has_no_altitude(pressure: float) -> None:
    assert math.isnan(altitude_of(pressure))
    assert pressure_of(1e6) < 1e-60


def test_scale_and_offset_come_after_a_function_and_are_inverted() -> None:
    assert scaled(PLAIN, 1.0, 0.0) is PLAIN
    degrees = scaled(FUNCTIONS["yaw"][0], 180.0 / math.pi, 90.0)
    north = quaternion_of(Angles(0.1, 0.2, 0.5 * math.pi))
    assert degrees.read(north) == pytest.approx(180.0)
    assert angles_of(written(degrees, north, 90.0)) == pytest.approx((0.1, 0.2, 0.0))
    assert scaled(FUNCTIONS["norm"][0], 2.0, 0.0).write is None


def imu(world: World) -> bytes:
    x, y, z, w = quaternion_of(Angles(0.1, 0.2, 0.3))
    return world.data(
        IMU,
        {
            "header.stamp.sec": 1,
            "header.frame_id": "base",
            "orientation.x": x,
            "orientation.y": y,
            "orientation.z": z,
            "orientation.w": w,
            "linear_acceleration.z": 9.81,
        },
    )


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("roll(orientation)", 0.1),
        (" pitch( orientation )", 0.2),
        ("yaw(orientation)", 0.3),
        ("roll(linear_acceleration)", 0.0),
        ("norm(linear_acceleration)", 9.81),
        ("atan2(linear_acceleration.z, linear_acceleration.x)", 0.5 * math.pi),
    ],
)
def test_a_field_may_be_a_function(world: World, field: str, value: float) -> None:
    codec = ScalarCodec(world.types, IMU, field)
    assert codec.sample(imu(world), 0).value == pytest.approx(value)
    assert codec.sample(imu(world), 0).stamp_ns == 1_000_000_000


def test_the_estimate_is_written_into_an_orientation(world: World) -> None:
    yaw, roll = (ScalarCodec(world.types, IMU, f"{name}(orientation)") for name in ("yaw", "roll"))
    written = yaw.template(imu(world)).filled(-2.0, 5)
    assert yaw.sample(written, 0) == (5, pytest.approx(-2.0), b"")
    assert roll.sample(written, 0).value == pytest.approx(0.1)
    blank = yaw.template(default_message(world.types, IMU)).filled(1.0, 0)
    assert yaw.sample(blank, 0).value == pytest.approx(1.0)


def test_scale_and_offset_of_a_field(world: World) -> None:
    plain = ScalarCodec(world.types, IMU, "linear_acceleration.z")
    codec = ScalarCodec(world.types, IMU, "linear_acceleration.z", -2.0, 1.0)
    assert codec.sample(imu(world), 0).value == -2.0 * 9.81 + 1.0
    written = codec.template(imu(world)).filled(-19.0, 0)
    assert plain.sample(written, 0).value == 10.0


def test_what_cannot_be_inverted_is_not_written(world: World) -> None:
    template = ScalarCodec(world.types, IMU, "norm(linear_acceleration)").template(imu(world))
    with pytest.raises(MessageError, match=r"'norm\(linear_acceleration\)' cannot be inverted"):
        template.filled(1.0, 0)


@pytest.mark.parametrize(
    ("field", "problem"),
    [
        ("sin(orientation.x)", "no function 'sin', expected one of roll, pitch, yaw, norm, atan2"),
        (
            "yaw(linear_acceleration)",
            "linear_acceleration is not a message with x, y, z, w, expected",
        ),
        ("norm(orientation.x)", "orientation.x is not a message with x, y, z, expected a vector"),
        ("yaw(attitude)", "no field 'attitude'"),
        ("atan2(orientation.x)", "atan2 takes 2 paths"),
        ("norm()", "norm takes one path"),
        ("altitude(header.frame_id)", "string is not a number"),
        ("orientation.yaw", "or a function: roll(orientation), pitch(orientation), yaw(orientatio"),
        ("", "roll(linear_acceleration), pitch(linear_acceleration), norm(angular_velocity)"),
    ],
)
def test_what_is_no_function_of_the_type_is_refused(world: World, field: str, problem: str) -> None:
    with pytest.raises(MessageError) as refusal:
        resolve_field(world.types, IMU, field)
    assert problem in str(refusal.value)


def test_functions_of_a_type_are_listed(world: World) -> None:
    assert computed_fields(world.types, "sensor_msgs/msg/FluidPressure") == [
        "altitude(fluid_pressure)"
    ]
    assert computed_fields(world.types, "geometry_msgs/msg/PoseArray") == [
        "roll(poses[0].orientation)",
        "pitch(poses[0].orientation)",
        "yaw(poses[0].orientation)",
        "norm(poses[0].position)",
    ]


@pytest.mark.parametrize("name", ["roll", "pitch"])
def test_an_angle_is_written_into_a_blank_vector(world: World, name: str) -> None:
    codec = ScalarCodec(world.types, IMU, f"{name}(linear_acceleration)")
    blank = default_message(world.types, IMU, "base_link")
    written = codec.template(blank).filled(0.3, 5)
    numbers = [
        ScalarCodec(world.types, IMU, f"linear_acceleration.{axis}").sample(written, 0).value
        for axis in "xyz"
    ]
    assert all(map(math.isfinite, numbers))
    assert codec.sample(written, 0).value == pytest.approx(0.3)
