# SPDX-License-Identifier: Apache-2.0
"""The share of time that the fusion spends in each mode."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.estimator import MODE_NAMES
from fuzzy_fusion_ros.core.numerics import seconds_between

LONGEST = 10.0
"""Longest time between two estimates that counts, seconds; longer silences belong to no mode."""


class ModeShares:
    """Adds up the time between estimates by the mode of the later one."""

    def __init__(self) -> None:
        self._seconds = dict.fromkeys(MODE_NAMES, 0.0)
        self._stamp_ns: int | None = None
        self._mode: int | None = None

    def see(self, mode: int, stamp_ns: int) -> None:
        """Take the next estimate."""
        before_ns, self._stamp_ns = self._stamp_ns, stamp_ns
        self._mode = mode
        if before_ns is None:
            return
        self._seconds[mode] += min(max(seconds_between(before_ns, stamp_ns), 0.0), LONGEST)

    def see_all(self, modes: NDArray[np.int64], stamps_ns: NDArray[np.int64]) -> None:
        """Take the next estimates in their order; sums are those of :meth:`see` to the bit."""
        if not modes.size:
            return
        self.see(int(modes[0]), int(stamps_ns[0]))
        lasted = np.minimum(np.maximum(np.diff(stamps_ns) * 1e-9, 0.0), LONGEST)
        for mode in np.flatnonzero(np.bincount(modes[1:])).tolist():
            own = lasted[modes[1:] == mode]
            self._seconds[mode] = float(np.cumsum(np.append(self._seconds[mode], own))[-1])
        self._stamp_ns, self._mode = int(stamps_ns[-1]), int(modes[-1])

    def shares(self) -> dict[str, float]:
        """Return the share of each mode, 0 to 1, by name; modes that never were are left out.

        A single estimate spans no time: its mode has all of it.
        """
        total = sum(self._seconds.values())
        if not total:
            return {} if self._mode is None else {MODE_NAMES[self._mode]: 1.0}
        return {
            MODE_NAMES[mode]: seconds / total
            for mode, seconds in self._seconds.items()
            if seconds > 0.0
        }


def shares_of(modes: Iterable[int], stamps_ns: Iterable[int]) -> dict[str, float]:
    """Return the shares over a series of estimates, as :meth:`ModeShares.shares`.

    Args:
        modes: Mode of each estimate.
        stamps_ns: Stamp of each, nanoseconds.
    """
    seen = ModeShares()
    for mode, stamp_ns in zip(modes, stamps_ns, strict=True):
        seen.see(mode, stamp_ns)
    return seen.shares()


def in_words(shares: Mapping[str, float]) -> str:
    """Return shares in words, such as ``FUSED 92 % of the time, S1_ONLY 8 %``."""
    first, *others = [f"{name} {100.0 * share:.3g} %" for name, share in shares.items()] or [""]
    return ", ".join([f"{first} of the time", *others]) if first else "no estimate"
