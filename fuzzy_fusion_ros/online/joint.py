# SPDX-License-Identifier: Apache-2.0
"""Brings together what several channels estimate at one stamp, since they share one message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from fuzzy_fusion_ros.core.estimator import S2_ONLY
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused, Together

MISSES = 5
"""Estimates in a row that a channel misses before the others go on without it."""


class Joint:
    """Gathers the estimates that one message or tick brings about, and lets whole stamps out.

    A stamp is whole if every live channel has its estimate of it. A channel is live from its first
    estimate on, until its S1 is lost, the state of any is cleared, or it has missed ``MISSES``
    estimates of the others in a row. This depends on samples and their order only, so node and
    replay agree.

    Attributes:
        withheld: Stamps not let out since a live channel had no estimate of them, by its name.
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

    def due(self) -> Iterator[Together]:
        """Yield what is whole, in rising order of stamps; what is not is given up."""
        restarts = sum([each.restarts for each in self._fusions.values()])
        if restarts != self._restarts:
            self._restarts = restarts
            self.reset()
        pending, self._pending = self._pending, {}
        for stamp_ns in sorted(pending):
            found = pending[stamp_ns]
            missing = [name for name in self._fusions if name not in found]
            if not missing or self._is_whole(found, missing):
                held = ((name, self._fusions[name].held_s2) for name in missing)
                yield Together(stamp_ns, found, {k: v for k, v in held if v is not None})
            for name, fused in found.items():
                self._missed[name] = MISSES if fused.estimate.mode == S2_ONLY else 0

    def _is_whole(self, found: Mapping[str, Fused], missing: Iterable[str]) -> bool:
        """Return whether no missing channel is live; note what those that are live miss."""
        live = [name for name in missing if self._missed[name] < MISSES]
        if any(fused.estimate.mode != S2_ONLY for fused in found.values()):
            for name in live:
                self._missed[name] += 1
                self.withheld[name] += 1
        return not live
