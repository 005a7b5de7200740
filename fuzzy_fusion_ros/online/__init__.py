# SPDX-License-Identifier: Apache-2.0
"""The fusion of two live streams: guards, trigger, estimator. No ROS, no files, no clock."""
