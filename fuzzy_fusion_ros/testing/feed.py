# SPDX-License-Identifier: Apache-2.0
"""Feeds a fusion node sample by sample and returns its estimates, in lockstep."""

from __future__ import annotations

from rclpy.duration import Duration
from rclpy.publisher import Publisher

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import (
    InstalledTypes,
    ScalarCodec,
    default_message,
    load_message_class,
)
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.testing.graph import Graph

START_NS = SECOND_NS
"""Stamp of time 0 of a feed: in ROS a stamp of zero means *no stamp*."""


class Feed:
    """Publishes both sensors and waits for the estimate of each sample.

    Attributes:
        s1: Publishes S1.
        s2: Publishes S2.
        estimates: All estimates received, in order.
    """

    def __init__(
        self,
        graph: Graph,
        *,
        s1: str = "/s1",
        s2: str = "/s2",
        estimate: str = "/estimate",
        type_name: str = POINT,
        field: str = "",
    ) -> None:
        """Create the publishers and wait until the node under test is connected.

        Args:
            graph: Where the node under test runs.
            s1: Topic of S1.
            s2: Topic of S2.
            estimate: Topic of the estimate.
            type_name: Type of all three, which must have a stamp.
            field: Path of the number in it; empty: the default of the type.

        Raises:
            MessageError: The type is not installed or has no such field.
            TimeoutError: No node subscribes to both sensors and publishes the estimate.
        """
        self._graph = graph
        self._began = False
        types = InstalledTypes()
        self._codec = ScalarCodec(types, type_name, field)
        self._template = self._codec.template(default_message(types, type_name))
        self.s1 = graph.publisher(s1, type_name)
        self.s2 = graph.publisher(s2, type_name)
        self.estimates: list[Sample] = []
        graph.node.create_subscription(
            load_message_class(type_name), estimate, self._on_estimate, ESTIMATE, raw=True
        )
        graph.spin_until_matched(self.s1, self.s2)
        graph.spin_until(
            lambda: graph.node.count_publishers(estimate) > 0, f"a publisher of {estimate}"
        )

    def __call__(self, at: float, s1: float, s2: float | None = None) -> float:
        """Publish S2, if given, then S1, and return the estimate with that stamp.

        Args:
            at: Stamp of both, seconds from the start of the feed.
            s1: Sample of S1, unit of the signal.
            s2: Sample of S2, unit of the signal.

        Raises:
            TimeoutError: No estimate with this stamp arrives.
        """
        seen = len(self.estimates)
        stamp_ns = self.send(at, s1, s2)
        found: list[float] = []

        def has_come() -> bool:
            nonlocal seen
            new = self.estimates[seen:]
            seen += len(new)
            found.extend(sample.value for sample in new if sample.stamp_ns == stamp_ns)
            return bool(found)

        self._graph.spin_until(has_come, f"an estimate stamped {stamp_ns} ns")
        return found[0]

    def send(self, at: float, s1: float | None = None, s2: float | None = None) -> int:
        """Publish S2, then S1, whichever are given, without waiting; return the stamp, ns."""
        stamp_ns = START_NS + round(at * SECOND_NS)
        if s2 is not None:
            self.publish(self.s2, Sample(stamp_ns, s2))
            if not self._began:  # discovery may not let S1 overtake the first S2
                self._began = True
                self.s2.wait_for_all_acked(Duration(seconds=5))
        if s1 is not None:
            self.publish(self.s1, Sample(stamp_ns, s1))
        return stamp_ns

    def publish(self, publisher: Publisher, sample: Sample) -> None:
        """Publish any sample, valid or not, on one of the publishers."""
        publisher.publish(self._template.filled(sample.value, sample.stamp_ns))

    def _on_estimate(self, data: bytes) -> None:
        self.estimates.append(self._codec.sample(data, 0))
