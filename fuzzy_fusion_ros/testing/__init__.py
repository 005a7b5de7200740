"""Tests of nodes without launch files: a ROS graph of its own, in this process, under control.

To test a parameter file of yours, copy this:

>>> from fuzzy_fusion_ros.testing import Harness
>>> with Harness() as harness:
...     node = harness.fusion_node(parameter_file="config/fusion_node.yaml")
...     feed = harness.feed()
...     for k in range(50):
...         estimate = feed(at=0.01 * k, s1=0.5 + 0.1 * (-1) ** k, s2=0.5)
>>> abs(estimate - 0.5) < 0.02
True

The graph has a domain of its own on this machine, so that tests can run side by side; nothing
leaves it. Nothing sleeps: :meth:`Harness.spin_until` runs the nodes until something is so.
"""

from fuzzy_fusion_ros.testing.domain import claimed_domain
from fuzzy_fusion_ros.testing.feed import Feed
from fuzzy_fusion_ros.testing.harness import Harness
from fuzzy_fusion_ros.testing.process import Process

__all__ = ["Feed", "Harness", "Process", "claimed_domain"]
