"""The messages that come out: the same bytes of rclpy's messages and of rosbags'."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from fuzzy_fusion_ros.bag import jazzy_types, serialize
from fuzzy_fusion_ros.bag.blank import blank_message
from fuzzy_fusion_ros.core.aggregator import Aggregate, FiringStrengths
from fuzzy_fusion_ros.core.errors import MessageError
from fuzzy_fusion_ros.core.estimator import FUSED, Estimate
from fuzzy_fusion_ros.core.fusion import Fused
from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction
from fuzzy_fusion_ros.core.parameters import EstimateParameters
from fuzzy_fusion_ros.messages import FieldPath, InstalledTypes, load_message_class
from fuzzy_fusion_ros.messages.outputs import (
    EXPLANATION,
    POINT,
    EstimateMessages,
    explain,
    point,
    strengths_message,
)

STAMP_NS = 12_345_678_901


def of_rclpy(msgtype: str) -> Any:
    """Return a blank message of rclpy."""
    return load_message_class(msgtype)()


def of_rosbags(msgtype: str) -> Any:
    """Return a blank message of rosbags."""
    return blank_message(jazzy_types(), msgtype)


WORLDS = {
    "rclpy": (of_rclpy, InstalledTypes()),
    "rosbags": (of_rosbags, jazzy_types()),
}


@pytest.fixture(params=WORLDS)
def world(request: pytest.FixtureRequest) -> tuple[Callable[[str], Any], Any]:
    """Whose messages are made, and who describes them."""
    return WORLDS[request.param]


def fused(prediction: Prediction = NO_PREDICTION) -> Fused:
    """Return an estimate of 0.5."""
    strengths = FiringStrengths(0.1, 0.2, 0.3, 0.4)
    aggregate = Aggregate(value=0.75, weight=0.25, drift=0.125, strengths=strengths)
    return Fused(STAMP_NS, Estimate(FUSED, 0.5, aggregate, prediction, False))


def test_both_worlds_give_the_same_bytes() -> None:
    found = {
        name: [(topic, serialize(message)) for topic, message in explain(new, with_prediction())]
        for name, (new, _) in WORLDS.items()
    }
    assert found["rclpy"] == found["rosbags"]


def with_prediction() -> Fused:
    """Return an estimate with a prediction behind it."""
    return fused(Prediction(exists=True, value=0.5))


def test_an_estimate_is_explained(world: tuple[Callable[[str], Any], Any]) -> None:
    found = dict(explain(world[0], with_prediction()))
    assert list(found) == list(EXPLANATION)
    values = {name: found[name].point.x for name in found if EXPLANATION[name] == POINT}
    assert values == {
        "weight": 0.25,
        "drift": 0.125,
        "aggregate": 0.75,
        "prediction": 0.5,
        "innovation": 0.25,
    }
    for name in values:
        stamp = found[name].header.stamp
        assert (stamp.sec, stamp.nanosec) == (12, 345_678_901)


def test_without_a_prediction_its_topics_are_silent(
    world: tuple[Callable[[str], Any], Any],
) -> None:
    assert list(dict(explain(world[0], fused()))) == [
        "weight",
        "drift",
        "aggregate",
        "firing_strengths",
    ]


def test_firing_strengths_are_labelled(world: tuple[Callable[[str], Any], Any]) -> None:
    message = strengths_message(world[0], FiringStrengths(0.1, 0.2, 0.3, 0.4))
    assert list(message.data) == [0.1, 0.2, 0.3, 0.4]
    assert [(dim.label, dim.size, dim.stride) for dim in message.layout.dim] == [
        ("difference: small, large", 2, 4),
        ("rate: small, large", 2, 2),
    ]


def test_a_point_is_filled_wholly(world: tuple[Callable[[str], Any], Any]) -> None:
    reused = world[0](POINT)
    point(lambda _: reused, 1, 7.0, "imu")
    message = point(lambda _: reused, STAMP_NS, 0.5)
    assert (message.header.frame_id, message.point.x) == ("", 0.5)


def messages_of(world: Any, parameters: EstimateParameters) -> EstimateMessages:
    """Return the maker of estimates where S2 is a PointStamped."""
    new, types = world
    return EstimateMessages(types, new, parameters, POINT, FieldPath("point.x"))


@pytest.mark.parametrize("name", ["", "geometry_msgs/PointStamped", POINT])
def test_it_copies_the_latest_s2(world: tuple[Callable[[str], Any], Any], name: str) -> None:
    made = messages_of(world, EstimateParameters(name))
    s2 = point(world[0], 1, 9.0, "gps")
    s2.point.y = 3.0
    made.see_s2(s2)
    message = made.message(fused())
    assert (made.type_name, made.field.text) == (POINT, "point.x")
    assert (message.header.frame_id, message.point.y, message.point.x) == ("gps", 3.0, 0.5)
    assert message.header.stamp.sec == 12
    assert s2.point.x == 9.0


def test_another_field_of_s2_can_take_it(world: tuple[Callable[[str], Any], Any]) -> None:
    made = messages_of(world, EstimateParameters("", "point.z"))
    made.see_s2(point(world[0], 1, 9.0))
    message = made.message(fused())
    assert (message.point.x, message.point.z) == (9.0, 0.5)


def test_a_type_of_its_own_keeps_the_frame(world: tuple[Callable[[str], Any], Any]) -> None:
    made = messages_of(world, EstimateParameters("sensor_msgs/msg/Temperature"))
    made.see_s2(point(world[0], 1, 9.0, "gps"))
    message = made.message(fused())
    assert (message.header.frame_id, message.temperature) == ("gps", 0.5)


def test_a_type_without_a_header_has_none(world: tuple[Callable[[str], Any], Any]) -> None:
    made = messages_of(world, EstimateParameters("std_msgs/msg/Float64"))
    made.see_s2(point(world[0], 1, 9.0, "gps"))
    assert made.message(fused()).data == 0.5


def test_a_field_that_is_not_there_is_refused(world: tuple[Callable[[str], Any], Any]) -> None:
    with pytest.raises(MessageError, match=r"has no field 'q'.*choose one of: point\.x"):
        messages_of(world, EstimateParameters("", "point.q"))
