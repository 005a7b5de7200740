"""Whether all that a lockstep run needs is connected, so that no first message is lost."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy

from fuzzy_fusion_ros.nodes.outlet import Outlet

SETTLED = 0.5
"""A best-effort subscription cannot ask again for what came before it knew us: let it, seconds."""


class Peers:
    """Watches the subscribers of some topics and the publishers of another."""

    def __init__(self, node: Node, outlets: Sequence[Outlet], source: str) -> None:
        self._node = node
        self._outlets = outlets
        self._source = source
        self._matched_since: float | None = None

    def ready(self, now: float) -> bool:
        """Return whether all are matched and, where that takes time, settled.

        Args:
            now: Steady time, seconds.
        """
        if self.missing():
            self._matched_since = None
            return False
        if self._matched_since is None:
            self._matched_since = now
        return self._all_reliable() or now - self._matched_since >= SETTLED

    def missing(self) -> list[str]:
        """Say what is not there yet, empty if all is."""
        missing = []
        for outlet in self._outlets:
            known = self._node.count_subscribers(outlet.topic)
            if known == 0:
                missing.append(f"nobody subscribes to {outlet.topic}")
            elif outlet.subscribers < known:
                missing.append(f"{outlet.subscribers} of {known} subscribers of {outlet.topic}")
        if self._node.count_publishers(self._source) == 0:
            missing.append(f"nobody publishes {self._source}")
        return missing

    def _all_reliable(self) -> bool:
        return all(
            each.qos_profile.reliability == ReliabilityPolicy.RELIABLE
            for outlet in self._outlets
            for each in self._node.get_subscriptions_info_by_topic(outlet.topic)
        )
