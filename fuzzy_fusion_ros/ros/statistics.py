"""What is counted while a node runs, for its diagnostics."""

from __future__ import annotations

import functools
import statistics
import time
from collections import deque
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")


class WorkTime:
    """Times calls, and forgets them when asked."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=100_000)

    def timed(self, callback: Callable[..., T]) -> Callable[..., T]:
        """Return a callback whose calls are timed."""

        @functools.wraps(callback)
        def call(*arguments: object) -> T:
            start = time.perf_counter()
            try:
                return callback(*arguments)
            finally:
                self._times.append(time.perf_counter() - start)

        return call

    def take(self) -> tuple[float, float]:
        """Return median and maximum since the last call, seconds; zeros if there was nothing."""
        if not self._times:
            return 0.0, 0.0
        result = statistics.median(self._times), max(self._times)
        self._times.clear()
        return result


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
