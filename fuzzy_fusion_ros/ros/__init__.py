# SPDX-License-Identifier: Apache-2.0
"""A toolkit for rclpy nodes that knows nothing of the fusion."""
