# SPDX-License-Identifier: Apache-2.0
"""The optimisers of scipy, started around a point, many runs in parallel.

Differential evolution copes with any cost. Where the cost is the root mean square of residuals that
are smooth in many parameters, least squares end the search: they reach in a hundred evaluations
what takes the evolution over a thousand.

Each run has its own seed and results are returned in order, so they do not depend on the number of
threads.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from types import TracebackType
from typing import NamedTuple, TypeVar

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square

MEMBERS = 20
"""Population of the differential evolution."""

CONVERGED = 1e-4
"""A run ends when the costs of its population differ by less than this share."""

LEAST_SQUARES_STEPS = 15
"""Steps of a least-squares fit, unless it is known to start near its end."""

_DIFFERENCE = 1e-2
"""Relative step of numerical derivatives: wide, as costs are rough where a delay line has steps."""

T = TypeVar("T")

Progress = Callable[[int, int], None]
"""Called with the number of evaluations done and the number planned."""


class Search(NamedTuple):
    """One run of the optimiser.

    Attributes:
        cost: What to minimise, over points of the unit cube.
        start: Where to start, shape (d,).
        spread: Standard deviation of the first population about it.
        evaluations: How often the evolution may call ``cost``; there is none where these are too
            few for two generations.
        seed: Seed of this run.
        residuals: What ``cost`` is the root mean square of, shape (n,), to end the search by least
            squares, from its start and from where the evolution ends; without it there are none.
        steps: Largest number of steps of least squares, each of which takes an evaluation for every
            dimension and one more.
    """

    cost: Callable[[Reals], float]
    start: Reals
    spread: float
    evaluations: int
    seed: tuple[int, ...]
    residuals: Callable[[Reals], Reals] | None = None
    steps: int = LEAST_SQUARES_STEPS

    @property
    def planned(self) -> int:
        """Largest number of evaluations."""
        if self.residuals is None:
            return self.evaluations
        ends = 2 if self.evolves else 1
        return self.evaluations + ends * self.steps * (self.start.size + 1)

    @property
    def evolves(self) -> bool:
        """Whether there is an evolution."""
        return self.start.size > 0 and self.evaluations >= 2 * MEMBERS


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
    start = np.clip(search.start, 0.0, 1.0)
    found = [_evolved(search, start) if search.evolves else Minimum(search.cost(start), start)]
    if search.residuals is not None and start.size > 0:
        starts = [start, found[0].point] if search.evolves else [start]
        found += [_least_squares(search.residuals, each, search.steps) for each in starts]
    return min(found, key=lambda minimum: minimum.cost)


def _evolved(search: Search, start: Reals) -> Minimum:
    """Run the differential evolution around a point, which is one of its members."""
    from scipy.optimize import differential_evolution  # costs start-up time

    generator = np.random.default_rng(search.seed)
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


def _least_squares(residuals: Callable[[Reals], Reals], start: Reals, steps: int) -> Minimum:
    """Fit by the trust-region reflective algorithm, within the unit cube."""
    from scipy.optimize import least_squares  # costs start-up time

    inside = np.clip(start, _DIFFERENCE, 1.0 - _DIFFERENCE)
    best = least_squares(
        residuals,
        inside,
        bounds=(0.0, 1.0),
        diff_step=_DIFFERENCE,
        x_scale=0.1,
        ftol=CONVERGED,
        xtol=CONVERGED,
        max_nfev=steps,
    )
    point = np.asarray(best.x, np.float64)
    return Minimum(root_mean_square(best.fun), point)


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

        def counted(function: Callable[[Reals], T]) -> Callable[[Reals], T]:
            def evaluate(point: Reals) -> T:
                nonlocal asked
                if self._stop.is_set():
                    raise Stopped
                asked += 1
                self._advance(1)
                return function(point)

            return evaluate

        residuals = None if search.residuals is None else counted(search.residuals)
        found = minimise(search._replace(cost=counted(search.cost), residuals=residuals))
        self._advance(search.planned - asked)
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
