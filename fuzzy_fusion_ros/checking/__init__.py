# SPDX-License-Identifier: Apache-2.0
"""What is wrong with two sensors, from their raw samples: no ROS, no files."""
