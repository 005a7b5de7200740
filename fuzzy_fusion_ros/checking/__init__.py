# SPDX-License-Identifier: Apache-2.0
"""What is wrong with two sensors, from their samples as they came: no ROS, no files."""
