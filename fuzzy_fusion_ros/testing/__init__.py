# SPDX-License-Identifier: Apache-2.0
"""Test nodes without launch files, in an isolated ROS graph.

To test your own parameter file, start from this:

>>> from fuzzy_fusion_ros.testing import Harness
>>> with Harness() as harness:
...     node = harness.fusion_node(parameter_file="config/fusion_node.yaml")
...     feed = harness.feed()
...     for k in range(50):
...         estimate = feed(at=0.01 * k, s1=0.5 + 0.1 * (-1) ** k, s2=0.5)
>>> abs(estimate - 0.5) < 0.02
True

The graph has its own DDS domain on this machine, so that tests can run in parallel, and no traffic
leaves the machine. Tests never sleep: :meth:`Harness.spin_until` spins the nodes until a predicate
is true.

The package installs two pytest fixtures; ``examples/robot`` is a template that uses them:

- ``fusion_harness``: an open :class:`Harness`;
- ``ros_domain``: a free DDS domain, which this process and its children have joined until the test
  ends. With both, the harness is in that domain.

Tests with and without launch_testing can be in the same run.

Importing this package does not import rclpy: names are imported when they are first used.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fuzzy_fusion_ros.testing.domain import claimed_domain
    from fuzzy_fusion_ros.testing.feed import Feed
    from fuzzy_fusion_ros.testing.harness import Harness
    from fuzzy_fusion_ros.testing.process import Process

__all__ = ["Feed", "Harness", "Process", "claimed_domain"]

_HOMES = {"Feed": "feed", "Harness": "harness", "Process": "process", "claimed_domain": "domain"}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
