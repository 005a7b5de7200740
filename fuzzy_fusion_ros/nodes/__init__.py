# SPDX-License-Identifier: Apache-2.0
"""The nodes: messages in, one call of the core, messages out. Together with testing, all of rclpy.

Each node is a class that takes rclpy's node options (``context``, ``parameter_overrides``,
``cli_args``, ``namespace`` ...), so that it runs in any executor; ``runtime`` runs one as a
process.
"""
