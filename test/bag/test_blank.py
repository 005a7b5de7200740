"""Messages with nothing in them: rclpy's, as far as zeros go."""

from __future__ import annotations

import pytest
from bag.making import definition_text

from fuzzy_fusion_ros.bag import BagTypes, Definition, Topic, jazzy_types, serialize
from fuzzy_fusion_ros.bag.blank import blank_message
from fuzzy_fusion_ros.core.errors import BagError
from fuzzy_fusion_ros.messages import load_message_class


@pytest.mark.parametrize(
    "msgtype",
    [
        "geometry_msgs/msg/PointStamped",
        "geometry_msgs/msg/AccelWithCovarianceStamped",
        "sensor_msgs/msg/JointState",
        "sensor_msgs/msg/Temperature",
        "sensor_msgs/msg/MagneticField",
        "std_msgs/msg/Bool",
        "std_msgs/msg/Float64",
        "std_msgs/msg/Float64MultiArray",
        "diagnostic_msgs/msg/DiagnosticArray",
    ],
)
def test_it_is_rclpys(msgtype: str) -> None:
    blank = serialize(blank_message(jazzy_types(), msgtype))
    assert blank == jazzy_types().serialize(load_message_class(msgtype)())


def test_fixed_arrays_of_messages_and_texts_are_filled() -> None:
    text = "float64[3] a\nstring[2] b\ngeometry_msgs/Point[2] c\nbool[2] d\nstring<=5 e\n"
    text += "=" * 80 + "\nMSG: geometry_msgs/Point\n" + definition_text("geometry_msgs/msg/Point")
    types = BagTypes([Topic("/x", "my_msgs/msg/Odd", definition=Definition("ros2msg", text))])
    message = blank_message(types, "my_msgs/msg/Odd")
    assert message.a.tolist() == [0.0, 0.0, 0.0]
    assert message.b == ["", ""]
    assert [each.x for each in message.c] == [0.0, 0.0]
    assert message.d.tolist() == [False, False]
    assert message.e == ""
    assert types.decode("my_msgs/msg/Odd", types.serialize(message)).b == ["", ""]


def test_an_unknown_type_is_refused() -> None:
    with pytest.raises(BagError, match="neither described by the bag nor part of ROS 2"):
        blank_message(jazzy_types(), "my_msgs/msg/Unknown")
