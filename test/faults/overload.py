# SPDX-License-Identifier: Apache-2.0
"""More samples than a node can take."""

from __future__ import annotations

import time
from typing import NamedTuple

from nodes.watching import Diagnostics

from faults.meeting import meet
from faults.streams import SECOND_NS, signal
from faults.usage import Watch
from faults.waiting import after, as_arguments
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.testing import Harness

LOST = "lost: queue overflow or dropped in transit"
STEP_NS = 1_000


class Flooded(NamedTuple):
    """What a flood did.

    Attributes:
        sent: Samples of S1.
        per_second: How fast they were sent.
        received: Those that the node took.
        lost: Those that it counted as lost.
        growth: Memory of the node, MiB.
        late_growth: The same, in the second half, MiB.
    """

    sent: int
    per_second: float
    received: int
    lost: int
    growth: float
    late_growth: float


def flood(seconds: float) -> Flooded:
    """Publish S1 as fast as possible to a fusion_node with a process of its own.

    Raises:
        TimeoutError: The newest sample does not come out, or samples after the flood do not.
        AssertionError: A sample is neither received nor counted as lost.
    """
    with Harness() as harness:
        node = harness.start("fusion_node", *as_arguments({"future_tolerance": 1e6}))
        feed, diagnostics = harness.feed(), Diagnostics(harness)
        meet(harness, feed)
        feed(0.5, s1=0.0, s2=0.0)
        before = diagnostics.next("fusion_node: s1").values
        watch = Watch(node.pid)
        watch.look()
        begin, sent = time.monotonic(), 0
        base_ns = 2 * SECOND_NS
        while time.monotonic() < begin + seconds:
            for _ in range(50):
                feed.publish(feed.s1, Sample(base_ns + sent * STEP_NS, signal(sent)))
                sent += 1
            harness.spin_until(after(1e-4))
            if sent % 1000 == 0:
                watch.look()
        took = time.monotonic() - begin
        last_ns = base_ns + (sent - 1) * STEP_NS
        harness.spin_until(
            lambda: feed.estimates and feed.estimates[-1].stamp_ns == last_ns, "the newest estimate"
        )
        at = (last_ns - SECOND_NS) * 1e-9
        for k in range(1, 11):
            feed(at + 0.01 * k, s1=0.5, s2=0.5)
        watch.look()
        received = lost = 0

        def all_accounted_for() -> bool:
            nonlocal received, lost
            said = diagnostics.of("fusion_node: s1")[-1].values
            received, lost = (int(said[each]) - int(before[each]) for each in ("received", LOST))
            return received + lost >= sent + 10

        harness.spin_until(all_accounted_for, "each sample received or counted as lost")
    assert received + lost == sent + 10
    return Flooded(sent, sent / took, received, lost, watch.growth, watch.late_growth)
