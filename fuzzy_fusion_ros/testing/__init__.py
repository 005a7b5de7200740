"""Test nodes without launch files, in an isolated ROS graph.

To test a parameter file of yours, start from this:

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
"""

from fuzzy_fusion_ros.testing.domain import claimed_domain
from fuzzy_fusion_ros.testing.feed import Feed
from fuzzy_fusion_ros.testing.harness import Harness
from fuzzy_fusion_ros.testing.process import Process

__all__ = ["Feed", "Harness", "Process", "claimed_domain"]
