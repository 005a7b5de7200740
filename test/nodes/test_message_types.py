# SPDX-License-Identifier: Apache-2.0
"""Any installed message type, by name and field path; the estimate drops in where S2 was."""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
from nodes.watching import WARN, Diagnostics, Log
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.serialization import serialize_message

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.nodes.fusion_node import FusionNode
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.graph import EVERY_MESSAGE


def stamped(type_name: str, at: float, **fields: Any) -> Any:
    """A message of a type, stamped in seconds."""
    message = load_message_class(type_name)(**fields)
    message.header.stamp.sec, message.header.stamp.nanosec = int(at), round(at % 1 * 1e9)
    message.header.frame_id = "sensor"
    return message


def imu(at: float, value: float) -> Any:
    message = stamped("sensor_msgs/msg/Imu", at)
    message.linear_acceleration.x = value
    message.linear_acceleration.z = 9.8
    message.orientation_covariance[0] = -1.0
    return message


def turned(at: float, value: float) -> Any:
    message = imu(at, 0.0)
    message.orientation.z, message.orientation.w = math.sin(0.5 * value), math.cos(0.5 * value)
    return message


def joint_state(at: float, value: float) -> Any:
    names, positions = ["wheel", "pole"], [7.0, value]
    return stamped("sensor_msgs/msg/JointState", at, name=names, position=positions)


class Kind(NamedTuple):
    """A type as a sensor.

    Attributes:
        type_name: The type.
        field: The path of the number.
        make: Makes a message of a stamp in seconds and a number.
        read: Reads the number.
    """

    type_name: str
    field: str
    make: Callable[[float, float], Any]
    read: Callable[[Any], float]


KINDS = {
    "Imu": Kind(
        "sensor_msgs/msg/Imu",
        "linear_acceleration.x",
        imu,
        lambda message: message.linear_acceleration.x,
    ),
    "JointState, by name": Kind(
        "sensor_msgs/msg/JointState",
        "name=pole:position",
        joint_state,
        lambda message: message.position[1],
    ),
    "JointState, by index": Kind(
        "sensor_msgs/msg/JointState",
        "position[1]",
        joint_state,
        lambda message: message.position[1],
    ),
    "Imu, yaw": Kind(
        "sensor_msgs/msg/Imu",
        "yaw(orientation)",
        turned,
        lambda message: round(2.0 * math.atan2(message.orientation.z, message.orientation.w), 9),
    ),
    "Temperature, short name": Kind(
        "sensor_msgs/Temperature",
        "",
        lambda at, x: stamped("sensor_msgs/msg/Temperature", at, temperature=x, variance=0.5),
        lambda message: message.temperature,
    ),
    "Range": Kind(
        "sensor_msgs/msg/Range",
        "range",
        lambda at, x: stamped("sensor_msgs/msg/Range", at, range=x, max_range=8.0),
        lambda message: message.range,
    ),
    "FluidPressure": Kind(
        "sensor_msgs/msg/FluidPressure",
        "fluid_pressure",
        lambda at, x: stamped("sensor_msgs/msg/FluidPressure", at, fluid_pressure=x, variance=3.0),
        lambda message: message.fluid_pressure,
    ),
}


@pytest.mark.parametrize("name", KINDS)
def test_the_estimate_is_s2s_message_with_number_and_stamp_replaced(
    harness: Harness, name: str
) -> None:
    kind = KINDS[name]
    full_name = kind.type_name.replace("/msg", "").replace("/", "/msg/")
    harness.fusion_node(
        {"s2.type": kind.type_name, "s2.field": kind.field, "aggregator.weight.very_small": 0.25}
    )
    s1 = harness.publisher("/s1")
    s2 = harness.publisher("/s2", full_name)
    estimates = harness.record("/estimate", full_name, ESTIMATE)
    harness.spin_until_matched(s1, s2)
    s2.publish(kind.make(5.0, 2.0))
    s2.wait_for_all_acked(Duration(seconds=5))  # it is to come first
    for at in (5.25, 5.5):
        s1.publish(stamped("geometry_msgs/msg/PointStamped", at))
    harness.spin_until(lambda: len(estimates) == 2)
    for at, estimate in zip((5.25, 5.5), estimates, strict=True):
        wanted = kind.make(at, 1.5)  # S2 is 2 and at rest, S1 is 0 and far off: it weighs 1/4
        assert kind.read(estimate) == 1.5
        assert estimate == unsure(wanted, kind.field)


def unsure(message: Any, field: str) -> Any:
    """A message that does not say how sure its number is."""
    if "orientation" in field:
        message.orientation_covariance[0] = 0.0
    elif hasattr(message, "variance"):
        message.variance = 0.0
    return message


JOINTS = [["wheel", "pole"], ["pole", "wheel"], ["a longer name", "wheel", "pole"], ["pole"]]


def test_the_number_is_followed_through_messages_of_any_layout(harness: Harness) -> None:
    kind = "sensor_msgs/msg/JointState"
    fields = {"s2.type": kind, "s2.field": "name=pole:position"}
    harness.fusion_node({**fields, "trigger": "pair", "s1.timeout": 1.0})
    s1, s2 = harness.publisher("/s1"), harness.publisher("/s2", kind)
    estimates = harness.record("/estimate", kind, ESTIMATE)
    harness.spin_until_matched(s1, s2)

    def has_come(k: int) -> bool:
        return len(estimates) > k

    for k, names in enumerate(JOINTS):
        positions = [2.0 if each == "pole" else 7.0 for each in names]
        message = stamped(kind, 5.0 + k, name=names, position=positions, velocity=k * [1.0])
        s2.publish(message)
        point = stamped("geometry_msgs/msg/PointStamped", 5.0 + k)
        point.point.x = 2.0
        s1.publish(point)
        harness.spin_until(functools.partial(has_come, k))
        assert estimates[k] == message
    s2.publish(stamped(kind, 9.0, name=["wheel"], position=[7.0]))
    s2.publish(stamped(kind, 10.0, name=["pole", "wheel"], position=[3.0, 7.0]))
    point = stamped("geometry_msgs/msg/PointStamped", 10.0)
    point.point.x = 3.0
    s1.publish(point)
    harness.spin_until(lambda: len(estimates) > len(JOINTS))
    assert list(estimates[-1].position) == [3.0, 7.0]


@pytest.mark.parametrize("name", KINDS)
def test_s1_is_read_from_any_type(harness: Harness, name: str) -> None:
    kind = KINDS[name]
    full_name = kind.type_name.replace("/msg", "").replace("/", "/msg/")
    parameters = {"s1.type": kind.type_name, "s1.field": kind.field, "s2.timeout": 0.01}
    harness.fusion_node(parameters)
    s1 = harness.publisher("/s1", full_name)
    estimates = harness.record("/estimate", qos=ESTIMATE)
    harness.spin_until_matched(s1)
    for at in (5.0, 5.25):  # S2 never speaks: S1 alone, as it came
        s1.publish(kind.make(at, 1.5))
    harness.spin_until(lambda: estimates)
    computed = "(" in kind.field  # there and back again rounds
    assert estimates[0].point.x == (pytest.approx(1.5, abs=1e-12) if computed else 1.5)
    assert (estimates[0].header.stamp.sec, estimates[0].header.stamp.nanosec) == (5, 250_000_000)


def test_messages_without_stamp_get_the_time_of_receipt_and_one_warning(
    harness: Harness, log: Log
) -> None:
    node = harness.fusion_node(
        {"s1.type": "std_msgs/msg/Float64", "s2.type": "std_msgs/msg/Float64"}
    )
    s1 = harness.publisher("/s1", "std_msgs/msg/Float64")
    s2 = harness.publisher("/s2", "std_msgs/msg/Float64")
    estimates = harness.record("/estimate", "std_msgs/msg/Float64", ESTIMATE)
    weights = harness.record("/fusion_node/weight")
    harness.spin_until_matched(s1, s2)
    harness.spin_until(lambda: node.count_subscribers("/fusion_node/weight"))
    before_ns = node.get_clock().now().nanoseconds
    number = load_message_class("std_msgs/msg/Float64")

    def feed_until_fused() -> bool:
        s2.publish(number(data=3.0))
        s1.publish(number(data=3.0))
        return bool(weights)

    harness.spin_until(feed_until_fused)
    after_ns = node.get_clock().now().nanoseconds
    assert estimates[0].data == 3.0
    stamp = weights[0].header.stamp
    assert before_ns <= stamp.sec * 10**9 + stamp.nanosec <= after_ns
    assert log.wait_for("/s1: std_msgs/msg/Float64 has no timestamp; using receive time")
    assert log.wait_for("/s2: std_msgs/msg/Float64 has no timestamp")
    assert log.count("/s1: std_msgs/msg/Float64 has no timestamp") == 1


def test_an_estimate_of_another_type_takes_the_frame_of_s2(harness: Harness) -> None:
    kind = "sensor_msgs/msg/Temperature"
    harness.fusion_node({"estimate.type": kind, "trigger": "pair"})
    s1, s2 = harness.publisher("/s1"), harness.publisher("/s2")
    estimates = harness.record("/estimate", kind, ESTIMATE)
    harness.spin_until_matched(s1, s2)
    for publisher in (s2, s1):
        publisher.publish(stamped("geometry_msgs/msg/PointStamped", 5.0))
    harness.spin_until(lambda: estimates)
    assert estimates[0].header.frame_id == "sensor"
    assert estimates[0].temperature == 0.0


def test_an_estimate_may_go_to_another_field_of_s2s_type(harness: Harness) -> None:
    harness.fusion_node({"estimate.field": "point.z", "trigger": "pair"})
    s1, s2 = harness.publisher("/s1"), harness.publisher("/s2")
    estimates = harness.record("/estimate", qos=ESTIMATE)
    harness.spin_until_matched(s1, s2)
    for publisher in (s2, s1):
        message = stamped("geometry_msgs/msg/PointStamped", 5.0)
        message.point.x = 4.0
        publisher.publish(message)
    harness.spin_until(lambda: estimates)
    assert (estimates[0].point.x, estimates[0].point.z) == (4.0, 4.0)


def test_a_message_without_the_element_is_counted_and_named(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    kind = "sensor_msgs/msg/JointState"
    parameters = {"s1.type": kind, "s1.field": "name=pole:position", "trigger": "pair"}
    harness.fusion_node(parameters)
    s1, s2 = harness.publisher("/s1", kind), harness.publisher("/s2")
    estimates = harness.record("/estimate", qos=ESTIMATE)
    harness.spin_until_matched(s1, s2)
    s1.publish(stamped(kind, 4.0, name=["wheel"], position=[1.0]))
    s1.publish(stamped(kind, 4.5, name=["wheel", "pole"], position=[1.0]))
    s2.publish(stamped("geometry_msgs/msg/PointStamped", 5.0))
    s1.publish(joint_state(5.0, 0.0))
    harness.spin_until(lambda: estimates)
    lacking = "dropped: message lacks the field"
    assert diagnostics.saying("fusion_node: s1", lacking).level == WARN
    status = diagnostics.having("fusion_node: s1", lacking, "2")
    assert status.values["last reason for a drop"] == "message lacks the field"
    assert "position has 1 elements" in status.values["last unreadable message"]


def test_what_is_no_message_of_the_type_is_counted_and_named(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    kind = "sensor_msgs/msg/JointState"
    parameters = {"s2.type": kind, "s2.field": "name=pole:position", "trigger": "pair"}
    harness.fusion_node(parameters)
    s1, s2 = harness.publisher("/s1"), harness.publisher("/s2", kind)
    estimates = harness.record("/estimate", kind, ESTIMATE)
    harness.spin_until_matched(s1, s2)
    whole = serialize_message(joint_state(4.0, 1.0))
    cut, long = whole[: len(whole) // 2], whole + bytes(64)
    endless = whole[:4] + b"\xff" * 100
    for data in (cut, long, endless, whole[:4], b"\xff" * 60, b"\0"):
        s2.publish(data)
    s2.publish(joint_state(5.0, 1.0))
    s1.publish(stamped("geometry_msgs/msg/PointStamped", 5.0))
    harness.spin_until(lambda: estimates)
    assert len(estimates) == 1
    lacking = "dropped: message lacks the field"
    assert diagnostics.saying("fusion_node: s2", lacking).level == WARN
    status = diagnostics.having("fusion_node: s2", lacking, "6")
    assert f"a message is not a {kind}: " in status.values["last unreadable message"]


def test_an_estimate_that_fits_into_no_message_is_an_error_in_diagnostics(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    kind = "sensor_msgs/msg/JointState"
    harness.fusion_node({"s2.type": kind, "s2.field": "name=pole:position", "s2.timeout": 0.01})
    s1 = harness.publisher("/s1")
    harness.spin_until_matched(s1)
    for at in (5.0, 5.25):  # S2 never speaks, so there is no message of it to copy
        s1.publish(stamped("geometry_msgs/msg/PointStamped", at))
    status = diagnostics.saying("fusion_node: fusion", "estimates not published: field")
    assert status.level == 2
    assert status.values["estimates not published"] == "1"


REFUSED = {
    "no such type": ({"s1.type": "std_msgs/msg/Flot64"}, "did you mean std_msgs/msg/Float64?"),
    "no such package": ({"s2.type": "nowhere_msgs/msg/Float64"}, "'nowhere_msgs/msg/Float64' is"),
    "malformed": ({"s1.type": "Float64"}, "message type 'Float64' is malformed: give package/msg"),
    "no such field": ({"s1.field": "point.w"}, "choose one of: point.x, point.y, point.z"),
    "no number": ({"s2.field": "header.frame_id"}, "not a number; choose one of: point.x"),
    "no default": ({"s1.type": "sensor_msgs/msg/Imu"}, "no default field; choose one of: ori"),
    "two units": (
        {"s1.type": "sensor_msgs/msg/FluidPressure", "s2.type": "sensor_msgs/msg/Range"},
        "s1 is in Pa (fluid_pressure of sensor_msgs/msg/FluidPressure), s2 is in m (range of",
    ),
    "no function": ({"s1.field": "sin(point.x)"}, "no function 'sin', expected one of roll, pitch"),
    "no inverse": ({"s2.field": "norm(point)"}, "which cannot be inverted: set estimate.type and"),
    "scale": ({"s2.scale": 0.0}, "parameter s2.scale: got 0.0, expected any other number"),
    "of the estimate": ({"estimate.type": "std_msgs/msg/String"}, "has no numeric field"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_type_or_field_that_is_none_refuses_the_start(harness: Harness, name: str) -> None:
    given, problem = REFUSED[name]
    with pytest.raises(FusionError) as refusal:
        harness.add(FusionNode, given)
    assert problem in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_another_type_on_the_topic_is_named_and_not_taken_for_ours(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair", "s1.timeout": 0.1})
    context = Context()  # one participant cannot have two types on one topic
    context.init()
    with contextlib.ExitStack() as stack:
        stack.callback(context.try_shutdown)
        stranger = Node("stranger", context=context)
        kind = load_message_class("std_msgs/msg/Float64")
        publisher = stranger.create_publisher(kind, "/s1", EVERY_MESSAGE)
        publisher.publish(kind(data=1e9))
        message = "published as std_msgs/msg/Float64, subscribed as geometry_msgs/msg/PointSta"
        assert diagnostics.saying("fusion_node: s1", message).level == WARN
        feed = harness.feed()
        assert feed(0.0, s1=1.0, s2=1.0) == 1.0
        stranger.destroy_node()
