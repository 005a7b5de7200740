"""The optimiser: scipy's differential evolution, started around a point, many runs in parallel.

Each run has its own seed and results are returned in order, so they do not depend on the number of
threads.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals

MEMBERS = 20
"""Population of the differential evolution."""

CONVERGED = 1e-4
"""A run ends when the costs of its population differ by less than this share."""

Progress = Callable[[int, int], None]
"""Called with the number of evaluations done and the number planned."""


class Search(NamedTuple):
    """One run of the optimiser.

    Attributes:
        cost: What to minimise, over points of the unit cube.
        start: Where to start, shape (d,).
        spread: Standard deviation of the first population about it.
        evaluations: How often ``cost`` may be called.
        seed: Seed of this run.
    """

    cost: Callable[[Reals], float]
    start: Reals
    spread: float
    evaluations: int
    seed: tuple[int, ...]


class Minimum(NamedTuple):
    """Result of a run.

    Attributes:
        cost: The least cost found.
        point: Where it is, shape (d,), in the unit cube.
    """

    cost: float
    point: Reals


def minimise(search: Search) -> Minimum:
    """Run the optimiser; the result is never worse than the start."""
    from scipy.optimize import differential_evolution  # costs start-up time

    generator = np.random.default_rng(search.seed)
    start = np.clip(search.start, 0.0, 1.0)
    if start.size == 0 or search.evaluations < 2 * MEMBERS:
        return Minimum(search.cost(start), start)
    cloud = start + search.spread * generator.standard_normal((MEMBERS, start.size))
    cloud[0] = start
    best = differential_evolution(
        search.cost,
        [(0.0, 1.0)] * start.size,
        init=np.clip(cloud, 0.0, 1.0),
        maxiter=search.evaluations // MEMBERS - 1,
        tol=CONVERGED,
        polish=False,
        seed=generator,
    )
    return Minimum(float(best.fun), np.asarray(best.x, np.float64))


class Stopped(Exception):
    """The pool is closing: the search ends early."""


class Pool:
    """Runs searches in threads and reports progress; a context manager."""

    def __init__(self, threads: int | None, progress: Progress, planned: int) -> None:
        """Start the threads.

        Args:
            threads: Number of threads; one for each usable processor unless given.
            progress: Called after every evaluation.
            planned: Largest number of evaluations of all runs together.
        """
        self._executor = ThreadPoolExecutor(threads or usable_processors())
        self._progress = progress
        self._planned = planned
        self._done = 0
        self._lock = threading.Lock()
        self._stop = threading.Event()

    def __enter__(self) -> Pool:
        """Return the pool."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Stop all searches and join the threads."""
        self._stop.set()
        self._executor.shutdown(cancel_futures=True)

    def run(self, searches: Sequence[Search]) -> list[Minimum]:
        """Run several searches in parallel; the results are in their order."""
        futures: list[Future[Minimum]] = [
            self._executor.submit(self._run, each) for each in searches
        ]
        return [each.result() for each in futures]

    def _run(self, search: Search) -> Minimum:
        asked = 0

        def cost(point: Reals) -> float:
            nonlocal asked
            if self._stop.is_set():
                raise Stopped
            asked += 1
            self._advance(1)
            return search.cost(point)

        found = minimise(search._replace(cost=cost))
        self._advance(search.evaluations - asked)
        return found

    def _advance(self, evaluations: int) -> None:
        with self._lock:
            self._done += evaluations
            self._progress(min(self._done, self._planned), self._planned)


def usable_processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
