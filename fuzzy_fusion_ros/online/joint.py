# SPDX-License-Identifier: Apache-2.0
"""Joins the estimates of several channels at one stamp, since they share one message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from fuzzy_fusion_ros.core.estimator import S2_ONLY
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused, Together

MISSES = 5
"""After missing this many consecutive estimates, a channel is not waited for."""


class Joint:
    """Collects the estimates caused by one message or tick, and releases complete stamps.

    A stamp is complete if every live channel has an estimate for it. A channel is live from its
    first estimate until its S1 is lost, the state of any channel is cleared, or it has missed
    ``MISSES`` consecutive estimates of the others. This depends on samples and their order only,
    so node and replay agree.

    Attributes:
        withheld: How many stamps were withheld because a live channel had no estimate for them,
            by the name of that channel.
    """

    def __init__(self) -> None:
        self._fusions: dict[str, Fusion] = {}
        self._pending: dict[int, dict[str, Fused]] = {}
        self._missed: dict[str, int] = {}
        self._restarts = 0
        self.withheld: Counter[str] = Counter()

    def add(self, channel: str, fusion: Fusion) -> None:
        """Wait for the estimates of a further channel."""
        self._fusions[channel] = fusion
        self._missed[channel] = MISSES

    def reset(self) -> None:
        """Wait for no channel before its next estimate: their state has been cleared."""
        self._missed = dict.fromkeys(self._fusions, MISSES)

    def take(self, channel: str, estimates: Iterable[Fused]) -> None:
        """Take estimates of a channel."""
        for fused in estimates:
            self._pending.setdefault(fused.stamp_ns, {})[channel] = fused

    def due(self) -> list[Together]:
        """Return complete stamps in ascending order; drop incomplete ones."""
        complete: list[Together] = []
        if not self._pending:
            return complete
        restarts = 0
        for fusion in self._fusions.values():
            restarts += fusion.restarts
        if restarts != self._restarts:
            self._restarts = restarts
            self.reset()
        pending, self._pending = self._pending, {}
        for stamp_ns in sorted(pending):
            found = pending[stamp_ns]
            if len(found) == len(self._fusions):
                complete.append(Together(stamp_ns, found))
            else:
                missing = [name for name in self._fusions if name not in found]
                if self._is_complete(found, missing):
                    held = {name: self._fusions[name].held_s2 for name in missing}
                    known = {name: value for name, value in held.items() if value is not None}
                    complete.append(Together(stamp_ns, found, known))
            for name, fused in found.items():
                self._missed[name] = MISSES if fused.estimate.mode == S2_ONLY else 0
        return complete

    def _is_complete(self, found: Mapping[str, Fused], missing: Iterable[str]) -> bool:
        """Return whether no missing channel is live; count a miss for each that is."""
        live = [name for name in missing if self._missed[name] < MISSES]
        if any(fused.estimate.mode != S2_ONLY for fused in found.values()):
            for name in live:
                self._missed[name] += 1
                self.withheld[name] += 1
        return not live
