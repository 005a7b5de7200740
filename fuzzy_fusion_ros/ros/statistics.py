# SPDX-License-Identifier: Apache-2.0
"""What is measured while a node runs, for its diagnostics."""

from __future__ import annotations

import statistics
import time
from collections import deque


class WorkTime:
    """Collects how long calls take, and forgets it when asked."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=100_000)

    def add(self, seconds: float) -> None:
        """Add a call."""
        self._times.append(seconds)

    def drain(self) -> list[float]:
        """Return the times since the last call, seconds."""
        times = list(self._times)
        self._times.clear()
        return times


def median_and_maximum(times: list[float]) -> tuple[float, float]:
    """Return both, zeros of nothing."""
    return (statistics.median(times), max(times)) if times else (0.0, 0.0)


class Rate:
    """Turns a count into a rate."""

    def __init__(self) -> None:
        self._count = 0
        self._time = time.monotonic()

    def of(self, count: int) -> float:
        """Return how fast a count has risen since the last call, 1/s."""
        now = time.monotonic()
        rate = (count - self._count) / max(now - self._time, 1e-9)
        self._count, self._time = count, now
        return rate
