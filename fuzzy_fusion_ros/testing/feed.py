"""Feeds a fusion node sample by sample, each waiting for its estimate."""

from __future__ import annotations

from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from fuzzy_fusion_ros.testing.harness import Harness

START_NS = SECOND_NS
"""Stamp of the time 0 of a feed: a stamp of zero means *no stamp* in ROS."""


class Feed:
    """Publishes both sensors and hands back estimates, in lockstep.

    Attributes:
        s1: Publishes S1.
        s2: Publishes S2.
        estimates: All estimates that have come, in order.
    """

    def __init__(
        self,
        harness: Harness,
        *,
        s1: str = "/s1",
        s2: str = "/s2",
        estimate: str = "/estimate",
        type_name: str = POINT,
        field: str = "",
    ) -> None:
        """Publish the sensors, and wait until the node under test is matched.

        Args:
            harness: The graph.
            s1: Topic of S1.
            s2: Topic of S2.
            estimate: Topic of the estimate.
            type_name: Type of all three; it has a stamp.
            field: Path of the number in it, the type's own if empty.

        Raises:
            MessageError: The type is not installed or has no such field.
            TimeoutError: Nobody subscribes to both sensors and publishes the estimate.
        """
        self._harness = harness
        self._began = False
        types = InstalledTypes()
        self._codec = ScalarCodec(types, type_name, field)
        self._template = self._codec.template(default_message(types, type_name))
        self.s1 = harness.publisher(s1, type_name)
        self.s2 = harness.publisher(s2, type_name)
        self.estimates: list[Sample] = []
        harness.node.create_subscription(
            load_message_class(type_name), estimate, self._on_estimate, ESTIMATE, raw=True
        )
        harness.spin_until_matched(self.s1, self.s2)
        harness.spin_until(
            lambda: harness.node.count_publishers(estimate) > 0, f"a publisher of {estimate}"
        )

    def __call__(self, at: float, s1: float, s2: float | None = None) -> float:
        """Publish S2, if given, and S1, and return the estimate at S1.

        Args:
            at: Stamp of both, seconds from the start of the feed.
            s1: Sample of S1, unit of the signal.
            s2: Sample of S2, unit of the signal.

        Raises:
            TimeoutError: No estimate of this stamp comes.
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

        self._harness.spin_until(has_come, f"an estimate stamped {stamp_ns} ns")
        return found[0]

    def send(self, at: float, s1: float | None = None, s2: float | None = None) -> int:
        """Publish S2, then S1, those that are given, and wait for nothing; return the stamp."""
        stamp_ns = START_NS + round(at * SECOND_NS)
        if s2 is not None:
            self.publish(self.s2, Sample(stamp_ns, s2))
            if not self._began:  # the first must not come after S1's, whoever is known first
                self._began = True
                self.s2.wait_for_all_acked(Duration(seconds=5))
        if s1 is not None:
            self.publish(self.s1, Sample(stamp_ns, s1))
        return stamp_ns

    def publish(self, publisher: Publisher, sample: Sample) -> None:
        """Publish any sample at all."""
        publisher.publish(self._template.filled(sample.value, sample.stamp_ns))

    def _on_estimate(self, data: bytes) -> None:
        self.estimates.append(self._codec.sample(data, 0))
