# SPDX-License-Identifier: Apache-2.0
"""Brings together what several channels estimate at one stamp, since they share one message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping

from fuzzy_fusion_ros.core.estimator import S2_ONLY
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused, Together


class Joint:
    """Gathers the estimates that one message or tick brings about, and lets whole stamps out.

    A stamp is whole if every channel that is live has its estimate of it. A channel is live from
    its first estimate on, until its S1 is lost or it has given none for S1's timeout. This depends
    on samples and their order only, so node and replay agree.

    Attributes:
        lacking: Stamps let out without a channel that was not live, by its name.
        withheld: Stamps not let out since a live channel had no estimate of them, by its name.
    """

    def __init__(self) -> None:
        self._fusions: dict[str, Fusion] = {}
        self._pending: dict[int, dict[str, Fused]] = {}
        self._last: dict[str, Fused] = {}
        self.lacking: Counter[str] = Counter()
        self.withheld: Counter[str] = Counter()

    def add(self, channel: str, fusion: Fusion) -> None:
        """Wait for the estimates of a further channel."""
        self._fusions[channel] = fusion

    def take(self, channel: str, estimates: Iterable[Fused]) -> None:
        """Take estimates of a channel."""
        for fused in estimates:
            self._pending.setdefault(fused.stamp_ns, {})[channel] = fused
            self._last[channel] = fused

    def due(self) -> Iterator[Together]:
        """Yield what is whole, in rising order of stamps; what is not is given up."""
        pending, self._pending = self._pending, {}
        for stamp_ns in sorted(pending):
            found = pending[stamp_ns]
            if len(found) == len(self._fusions) or self._is_whole(stamp_ns, found):
                yield Together(stamp_ns, found)

    def _is_whole(self, stamp_ns: int, found: Mapping[str, Fused]) -> bool:
        missing = [name for name in self._fusions if name not in found]
        live = [name for name in missing if self._is_live(name, stamp_ns)]
        if not live:
            self.lacking.update(missing)
        elif any(fused.estimate.mode != S2_ONLY for fused in found.values()):
            self.withheld.update(live)
        return not live

    def _is_live(self, name: str, stamp_ns: int) -> bool:
        last, fusion = self._last.get(name), self._fusions[name]
        if last is None or last.estimate.mode == S2_ONLY:
            return False
        timeout = fusion.s1.timeout(fusion.parameters.s1.timeout)
        return abs(seconds_between(last.stamp_ns, stamp_ns)) <= timeout
