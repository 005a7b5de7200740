# SPDX-License-Identifier: Apache-2.0
"""More samples than the node can take: the newest win, the rest is counted."""

from __future__ import annotations

import pytest
from nodes.watching import Diagnostics

from faults.overload import LOST, flood
from faults.streams import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.testing import Harness


def test_of_what_comes_at_once_the_newest_are_taken_and_the_rest_is_counted() -> None:
    """The node does not run while 1000 samples come: its queue holds the newest few."""
    depth = input_profile("sensor_data").depth
    with Harness() as harness:
        harness.fusion_node({"qos": "sensor_data"})
        feed, diagnostics = harness.feed(), Diagnostics(harness)
        feed(0.0, s1=1.0, s2=1.0)
        stamps = [2 * SECOND_NS + k for k in range(1000)]
        for stamp_ns in stamps:
            feed.publish(feed.s1, Sample(stamp_ns, 2.0))
        harness.spin_until(lambda: feed.estimates[-1].stamp_ns == stamps[-1])
        assert [each.stamp_ns for each in feed.estimates[1:]] == stamps[-depth:]
        said = diagnostics.next("fusion_node: s1").values
        assert int(said["received"]) == 1 + depth
        assert int(said[LOST]) == 1000 - depth
        assert feed(2.0, s1=1.0, s2=1.0) == 1.0


@pytest.mark.slow("a flood of 30 s: the node loads what checks its data after 10 s")
def test_a_flood_is_survived_and_over_at_once() -> None:
    flooded = flood(30.0)
    assert flooded.growth < 16.0
    assert flooded.late_growth < 2.0
