# SPDX-License-Identifier: Apache-2.0
"""Blank messages are those that rclpy and rosbags make."""

from __future__ import annotations

import pytest
from messages.worlds import World
from rclpy.serialization import deserialize_message

from fuzzy_fusion_ros.bag import jazzy_types
from fuzzy_fusion_ros.messages import InstalledTypes, default_message, load_message_class
from fuzzy_fusion_ros.parameters.errors import MessageError

TYPES = (
    "diagnostic_msgs/msg/DiagnosticStatus",
    "geometry_msgs/msg/PointStamped",
    "geometry_msgs/msg/PoseWithCovarianceStamped",
    "sensor_msgs/msg/CameraInfo",
    "sensor_msgs/msg/Imu",
    "sensor_msgs/msg/JointState",
    "std_msgs/msg/Bool",
    "std_msgs/msg/Empty",
    "std_msgs/msg/Float64MultiArray",
)


@pytest.mark.parametrize("msgtype", TYPES)
def test_a_blank_message_is_what_rclpy_makes(msgtype: str) -> None:
    data = default_message(InstalledTypes(), msgtype)
    assert data == default_message(jazzy_types(), msgtype)
    kind = load_message_class(msgtype)
    if msgtype == "diagnostic_msgs/msg/DiagnosticStatus":
        assert deserialize_message(data, kind).level == b"\0"
    else:
        assert deserialize_message(data, kind) == kind()


def test_a_custom_type_is_blank_too(rosbags: World) -> None:
    msgtype = "test_msgs/msg/Numbers"
    assert default_message(rosbags.types, msgtype) == rosbags.data(msgtype)


def test_the_frame_is_that_of_the_header() -> None:
    data = default_message(InstalledTypes(), "sensor_msgs/msg/Imu", "imu_link")
    message = deserialize_message(data, load_message_class("sensor_msgs/msg/Imu"))
    assert message.header.frame_id == "imu_link"
    assert message.orientation.w == 1.0


def test_an_unknown_type_is_refused(world: World) -> None:
    with pytest.raises(MessageError, match="my_msgs/msg/Unknown"):
        default_message(world.types, "my_msgs/msg/Unknown")
