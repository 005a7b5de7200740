# SPDX-License-Identifier: Apache-2.0
"""The messages that come out."""

from __future__ import annotations

import dataclasses
import math
from itertools import permutations
from typing import Any

import pytest
from messages.worlds import World
from rclpy.serialization import deserialize_message

from fuzzy_fusion_ros.core.aggregator import Aggregate, FiringStrengths
from fuzzy_fusion_ros.core.estimator import FUSED, Estimate, initial_state
from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction
from fuzzy_fusion_ros.messages import (
    InstalledTypes,
    ScalarCodec,
    default_message,
    load_message_class,
)
from fuzzy_fusion_ros.messages.functions import Angles, quaternion_of
from fuzzy_fusion_ros.messages.outputs import (
    EXPLANATION,
    JOINTS,
    POINT,
    EstimateMessages,
    EstimateSource,
    explain,
    point_template,
    strengths_message,
)
from fuzzy_fusion_ros.online.verdict import Fused, Together
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import EstimateParameters, Parameters

STAMP_NS = 12_345_678_901
TEMPERATURE = "sensor_msgs/msg/Temperature"


def read(data: bytes, msgtype: str = POINT) -> Any:
    """Return a message as rclpy reads it."""
    return deserialize_message(data, load_message_class(msgtype))


def fused(s2_message: bytes = b"", prediction: Prediction = NO_PREDICTION) -> Fused:
    """Return an estimate of 0.5."""
    strengths = FiringStrengths(0.1, 0.2, 0.3, 0.4)
    aggregate = Aggregate(value=0.75, weight=0.25, drift=0.125, strengths=strengths)
    estimate = Estimate(FUSED, 0.5, aggregate, prediction, False, 0.5)
    return Fused(STAMP_NS, estimate, initial_state(Parameters()), s2_message)


def with_prediction() -> Fused:
    """Return an estimate with a prediction behind it."""
    return fused(prediction=Prediction(exists=True, value=0.5))


def explained(estimate: Fused) -> dict[str, Any]:
    """Return what stands behind an estimate, as rclpy reads it."""
    found = explain(point_template(InstalledTypes()), estimate)
    return {name: read(data, EXPLANATION[name]) for name, data in found}


def test_an_estimate_is_explained() -> None:
    found = explained(with_prediction())
    assert list(found) == list(EXPLANATION)
    values = {name: found[name].point.x for name in found if EXPLANATION[name] == POINT}
    assert values == {
        "weight": 0.25,
        "drift": 0.125,
        "aggregate": 0.75,
        "prediction": 0.5,
        "innovation": 0.25,
        "standard_deviation": 0.5,
    }
    for name in values:
        stamp = found[name].header.stamp
        assert (stamp.sec, stamp.nanosec) == (12, 345_678_901)


def test_without_a_prediction_its_topics_are_silent() -> None:
    silent = {"prediction", "innovation"}
    assert list(explained(fused())) == [each for each in EXPLANATION if each not in silent]


def test_an_unknown_standard_deviation_is_silent() -> None:
    estimate = fused().estimate._replace(standard_deviation=0.0)
    assert "standard_deviation" not in explained(dataclasses.replace(fused(), estimate=estimate))


def test_firing_strengths_are_stamped_and_named(world: World) -> None:
    data = strengths_message(FiringStrengths(0.1, 0.2, 0.3, 0.4), STAMP_NS)
    message = read(data, EXPLANATION["firing_strengths"])
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (12, 345_678_901)
    assert dict(zip(message.name, message.position, strict=True)) == {
        "difference_small_rate_small": 0.1,
        "difference_small_rate_large": 0.2,
        "difference_large_rate_small": 0.3,
        "difference_large_rate_large": 0.4,
    }
    by_name = ScalarCodec(world.types, JOINTS, "name=difference_large_rate_small:position")
    assert by_name.sample(data, 0)[:2] == (STAMP_NS, 0.3)


def test_a_point_has_a_frame() -> None:
    message = read(point_template(InstalledTypes(), "imu").filled(0.5, STAMP_NS))
    assert (message.header.frame_id, message.header.stamp.sec, message.point.x) == ("imu", 12, 0.5)


def estimates(world: World, parameters: EstimateParameters) -> EstimateMessages:
    """Return the maker of estimates where S2 is a PointStamped."""
    s2 = ScalarCodec(world.types, POINT)
    return EstimateMessages(world.types, {"": EstimateSource(parameters, s2)})


def alone(estimate: Fused) -> Together:
    """Return an estimate as that of the only channel."""
    return Together(estimate.stamp_ns, {"": estimate})


def s2(world: World) -> bytes:
    """Return a message of S2."""
    return world.data(POINT, {"header.frame_id": "gps", "point.x": 9.0, "point.y": 3.0})


@pytest.mark.parametrize("name", ["", "geometry_msgs/PointStamped", POINT])
def test_it_copies_the_latest_s2(world: World, name: str) -> None:
    made = estimates(world, EstimateParameters(name))
    older = world.data(POINT, {"header.frame_id": "an older one"})
    assert read(made.message(alone(fused(older)))).header.frame_id == "an older one"
    message = read(made.message(alone(fused(s2(world)))))
    assert (made.type_name, made.codecs[""].field.text) == (POINT, "point.x")
    assert (message.header.frame_id, message.point.y, message.point.x) == ("gps", 3.0, 0.5)
    assert message.header.stamp.sec == 12


def test_before_s2_the_rest_is_blank(world: World) -> None:
    data = estimates(world, EstimateParameters()).message(alone(fused()))
    codec = ScalarCodec(world.types, POINT)
    assert data == codec.template(default_message(world.types, POINT)).filled(0.5, STAMP_NS)


def test_another_field_of_s2_can_take_it(world: World) -> None:
    made = estimates(world, EstimateParameters("", "point.z"))
    message = read(made.message(alone(fused(s2(world)))))
    assert (message.point.x, message.point.z) == (9.0, 0.5)


def test_a_type_of_its_own_keeps_the_frame(world: World) -> None:
    made = estimates(world, EstimateParameters(TEMPERATURE))
    for _ in range(2):
        message = read(made.message(alone(fused(s2(world)))), TEMPERATURE)
        assert (message.header.frame_id, message.temperature) == ("gps", 0.5)


def test_a_type_without_a_header_has_none(world: World) -> None:
    made = estimates(world, EstimateParameters("std_msgs/msg/Float64"))
    assert read(made.message(alone(fused(s2(world)))), "std_msgs/msg/Float64").data == 0.5


def test_a_field_that_is_not_there_is_refused(world: World) -> None:
    with pytest.raises(MessageError, match=r"has no field 'q'.*choose one of: point\.x"):
        estimates(world, EstimateParameters("", "point.q"))


def test_an_element_that_is_not_there_is_an_error_of_that_estimate(world: World) -> None:
    kind = "sensor_msgs/msg/JointState"
    codec = ScalarCodec(world.types, kind, "position[1]")
    made = EstimateMessages(world.types, {"": EstimateSource(EstimateParameters(), codec)})
    with pytest.raises(MessageError, match="position has 0 elements in this message"):
        made.message(alone(fused()))
    data = made.message(alone(fused(world.data(kind, {"position": [1.0, 2.0]}))))
    assert list(read(data, kind).position) == [1.0, 0.5]


def together(world: World, msgtype: str, fields: dict[str, str]) -> EstimateMessages:
    """Return the maker of estimates of several channels, by their fields."""
    sources = {
        name: EstimateSource(EstimateParameters(), ScalarCodec(world.types, msgtype, field))
        for name, field in fields.items()
    }
    return EstimateMessages(world.types, sources)


def valued(values: dict[str, float], s2_message: bytes) -> Together:
    """Return estimates of several channels."""
    one = fused(s2_message)
    return Together(
        STAMP_NS,
        {
            name: dataclasses.replace(one, estimate=one.estimate._replace(value=value))
            for name, value in values.items()
        },
    )


IMU = "sensor_msgs/msg/Imu"
LEVEL = {"orientation.w": 1.0, "linear_acceleration.z": 9.81}
SETS = {
    "quaternion": {f"{each}(orientation)": each for each in ("roll", "pitch", "yaw")},
    "vector": {f"{each}(linear_acceleration)": each for each in ("roll", "pitch")},
    "numbers": {f"angular_velocity.{axis}": axis for axis in "xyz"},
}


@pytest.mark.parametrize("fields", SETS.values(), ids=list(SETS))
def test_channels_write_all_their_fields_into_one_message(
    world: World, fields: dict[str, str]
) -> None:
    made = together(world, IMU, {name: field for field, name in fields.items()})
    values = dict(zip(fields.values(), (0.3, -0.2, 0.1), strict=False))
    data = made.message(valued(values, world.data(IMU, LEVEL)))
    for field, name in fields.items():
        stamp_ns, value, _ = ScalarCodec(world.types, IMU, field).sample(data, 0)
        assert (stamp_ns, value) == (STAMP_NS, pytest.approx(values[name], abs=1e-12))


def test_a_channel_without_an_estimate_gives_what_it_holds_of_s2(world: World) -> None:
    made = together(world, POINT, {"x": "point.x", "y": "point.y"})
    without = valued({"x": 0.5}, s2(world))
    message = read(made.message(without._replace(held={"y": 7.0})))
    assert (message.point.x, message.point.y) == (0.5, 7.0)
    assert made.lacking == {"y": 1}
    with pytest.raises(MessageError, match="channel y has neither an estimate nor a value of S2"):
        made.message(without)
    assert made.lacking == {"y": 1}


@pytest.mark.parametrize("of", ["orientation", "linear_acceleration"])
def test_the_order_of_channels_does_not_turn_angles_beyond_a_right_angle(
    world: World, of: str
) -> None:
    values = {"roll": 0.1, "pitch": 1.7, "yaw": 0.3}
    if of == "linear_acceleration":
        del values["yaw"]
    found = []
    for names in permutations(values):
        made = together(world, IMU, {name: f"{name}({of})" for name in names})
        data = made.message(valued(values, world.data(IMU, LEVEL)))
        found.append([ScalarCodec(world.types, IMU, f"{of}.{k}").value(data) for k in "xyz"])
    if of == "orientation":
        expected = list(quaternion_of(Angles(**values))[:3])
    else:
        across = 9.81 * math.cos(1.7)
        expected = [-9.81 * math.sin(1.7), across * math.sin(0.1), across * math.cos(0.1)]
    assert found == [pytest.approx(expected, abs=1e-12)] * len(found)


def test_the_newest_message_of_s2_is_copied(world: World) -> None:
    made = together(world, POINT, {"x": "point.x", "y": "point.y"})
    older = valued({"x": 0.5}, world.data(POINT, {"header.frame_id": "an older one"})).fused
    newer = {"y": dataclasses.replace(fused(s2(world)), s2_ns=1)}
    for both in ({**older, **newer}, {**newer, **older}):
        assert read(made.message(Together(STAMP_NS, both))).header.frame_id == "gps"


@pytest.mark.parametrize("field", ["point.x", "point.y"])
def test_a_variance_over_an_estimate_is_refused(world: World, field: str) -> None:
    sources = {
        name: EstimateSource(
            EstimateParameters(variance_field=variance),
            ScalarCodec(world.types, POINT, f"point.{name}"),
        )
        for name, variance in (("x", field), ("y", ""))
    }
    with pytest.raises(
        MessageError,
        match=f"x.estimate.variance_field is {field} of .*, which holds the estimate of channel "
        f"{field[-1]}: name the field of a variance",
    ):
        EstimateMessages(world.types, sources)


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("angular_velocity.x", "angular_velocity.x"),
        ("roll(orientation)", "roll(orientation)"),
        ("roll(orientation)", "orientation.x"),
        ("atan2(angular_velocity.x, angular_velocity.y)", "angular_velocity.x"),
    ],
)
def test_channels_that_write_the_same_numbers_are_refused(
    world: World, first: str, second: str
) -> None:
    with pytest.raises(
        MessageError, match=r"channels a and b both write .* of sensor_msgs/msg/Imu"
    ):
        together(world, IMU, {"a": first, "b": second})
