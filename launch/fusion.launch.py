# SPDX-License-Identifier: Apache-2.0
"""Starts a fusion_node. Include it once per pair of sensors, in its own namespace and GroupAction.

ros2 launch fuzzy_fusion_ros fusion.launch.py params_file:=$PWD/tuned.yaml s1:=/imu s2:=/gnss
"""

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

from launch import LaunchDescription

PACKAGE = "fuzzy_fusion_ros"


def generate_launch_description():
    """Return the arguments and the node."""
    defaults = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "fusion_node.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                default_value=defaults,
                description="ROS parameter YAML, such as one written by tune",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the node"
            ),
            DeclareLaunchArgument("s1", default_value="s1", description="topic of S1"),
            DeclareLaunchArgument("s2", default_value="s2", description="topic of S2"),
            DeclareLaunchArgument(
                "estimate", default_value="estimate", description="topic of the estimate"
            ),
            DeclareLaunchArgument(
                "use_sim_time", default_value="false", description="use the time on /clock"
            ),
            Node(
                package=PACKAGE,
                executable="fusion_node",
                name="fusion_node",
                namespace=LaunchConfiguration("namespace"),
                # Not among the parameters, where launch would go on without a file that is missing.
                ros_arguments=["--params-file", LaunchConfiguration("params_file")],
                parameters=[{"use_sim_time": LaunchConfiguration("use_sim_time")}],
                remappings=[
                    ("s1", LaunchConfiguration("s1")),
                    ("s2", LaunchConfiguration("s2")),
                    ("estimate", LaunchConfiguration("estimate")),
                ],
                output="screen",
            ),
        ]
    )
