# SPDX-License-Identifier: Apache-2.0
"""Fitting parameters to a target: a short search from several starts, a long one from the best."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers, numbers_with, replace
from fuzzy_fusion_ros.tuning.characterise import TINY
from fuzzy_fusion_ros.tuning.kernel import Output, joined
from fuzzy_fusion_ros.tuning.search import LEAST_SQUARES_STEPS, Minimum, Pool, Search
from fuzzy_fusion_ros.tuning.space import Space

FREEDOM = 4.0
"""Degrees of freedom of the Student-t distribution of innovations: outliers of S2 weigh little."""

_SIZES = np.geomspace(1e-4, 3.0, 200)

WORST = 300.0
"""A mean of logarithms beyond this is as bad as any."""

REFIT_STEPS = 3
"""Steps of least squares in a fit to a part, which starts where the fit to the whole ended."""

_START_SPREAD = 0.12
_FINAL_SPREAD = 0.1


class Problem(NamedTuple):
    """What is fitted, and to what.

    Attributes:
        recordings: One or several; arrays over them have n samples of S1 in all.
        target: The signal, at each S1 sample, shape (n,).
        counted: Where it counts, shape (n,).
        base: Parameters; a fit changes only those in its space.
        with_truth: Whether the target is a truth, and not made from both sensors.
    """

    recordings: Sequence[Series]
    target: Reals
    counted: Flags
    base: Parameters
    with_truth: bool = True

    def misfit(self, parameters: Parameters, counted: Flags | None = None) -> float:
        """Return the root mean square error of the estimator without its predictor.

        Args:
            parameters: Of the estimator.
            counted: Where errors count; as in the problem unless given.
        """
        where = self.counted if counted is None else counted
        value = joined(parameters, self.recordings).value
        return root_mean_square(value[where] - self.target[where])

    def surprise(self, parameters: Parameters, counted: Flags | None = None) -> float:
        """Return how badly the observer predicts S2, which needs no target, unit of the signal.

        The geometric mean of what the likelihood of an innovation is the inverse of, each with the
        variance that the observer expects; infinite where there are none. It grows in proportion
        with the innovations where they are as expected.

        Args:
            parameters: Of the estimator.
            counted: As in :meth:`misfit`.
        """
        output = joined(parameters, self.recordings)
        where = self._at_s2(self.counted if counted is None else counted)
        return math.exp(min(unlikelihood(output, parameters.s2.noise, where), WORST))

    def loss(self, parameters: Parameters, counted: Flags | None = None) -> float:
        """Return what a fit lowers: the misfit, or without a truth the surprise of the observer."""
        if self.with_truth or not parameters.s1.bias_time_constant > 0.0:
            return self.misfit(parameters, counted)
        return self.surprise(parameters, counted)

    def by_recording(self, values: Reals | Flags) -> list[Any]:
        """Split an array over all samples of S1, shape (n,), into one for each recording."""
        ends = np.cumsum([each.s1.size for each in self.recordings])
        return np.split(values, ends[:-1])

    def _at_s2(self, counted: Flags) -> Flags:
        """Return which samples of S2 came where samples of S1 count, shape (m,)."""
        pairs = zip(self.recordings, self.by_recording(counted), strict=True)
        return np.concatenate([_arrived(series, own) for series, own in pairs])


def unlikelihood(output: Output, noise: float, counted: Flags) -> float:
    """Return the mean negative log-likelihood of innovations, less a constant.

    Args:
        output: Of a run.
        noise: Standard deviation of S2's noise, unit of the signal.
        counted: Which samples of S2 count, shape (m,).
    """
    there = counted & np.isfinite(output.innovation)
    if not there.any():
        return np.inf
    return _student(output.innovation[there], output.variance[there] * noise**2)


def plain_surprise(error: Reals) -> float:
    """Return the surprise of errors that all have one variance, the likeliest.

    Args:
        error: Errors of some prediction of S2, shape (m,).
    """
    typical = max(root_mean_square(error), TINY)
    return math.exp(min(_student(error, np.square(each * typical)) for each in _SIZES))


def _student(error: Reals, variance: Reals) -> float:
    """Return the mean negative log-likelihood of errors of Student's distribution."""
    tail = 0.5 * (FREEDOM + 1.0) * np.log1p(error**2 / (FREEDOM * variance))
    return float(np.mean(0.5 * np.log(variance) + tail))


def _arrived(series: Series, counted: Flags) -> Flags:
    """Return which samples of S2 came where samples of S1 count, shape (m,)."""
    arrival = np.searchsorted(series.s2_known, np.arange(series.s2.size) + 1)
    return np.append(counted, False)[arrival]


class Evaluations(NamedTuple):
    """How often the evolution may evaluate the misfit; least squares, if any, come on top.

    Attributes:
        start: From each start.
        finalist: From each of the best of these.
        part: In each fit to a part of the recording.
        finalists: How many of the starts are continued from.
    """

    start: int
    finalist: int
    part: int
    finalists: int = 1


class FitSpec(NamedTuple):
    """What a fit moves and where it starts.

    Attributes:
        space: What moves.
        starts: Values to start from, by dotted name; shares as shares.
        evaluations: How many evaluations a fit may take.
    """

    space: Space
    starts: Sequence[Mapping[str, float]]
    evaluations: Evaluations

    def planned(self, with_truth: bool, folds: int) -> int:
        """Return the largest number of evaluations of a fit and its refits.

        Args:
            with_truth: Whether searches end by least squares.
            folds: Number of refits.
        """
        finalists, evaluations = min(self.evaluations.finalists, len(self.starts)), self.evaluations
        least = finalists * evaluations.finalist + folds * evaluations.part
        if with_truth:
            steps = finalists * LEAST_SQUARES_STEPS + folds * REFIT_STEPS
            least += steps * (len(self.space.axes) + 1)
        return len(self.starts) * evaluations.start + least


def cost_of(
    problem: Problem, spec: FitSpec, counted: Flags | None = None
) -> Callable[[Reals], float]:
    """Return what a fit minimises: the loss, increased with the distance from usual values.

    Args:
        problem: What is fitted.
        spec: How.
        counted: Where errors count; as in the problem unless given.
    """

    base = numbers(replace(problem.base, spec.space.values(spec.space.point({}))))

    def cost(point: Reals) -> float:
        parameters = numbers_with(base, spec.space.moved(point))
        return problem.loss(parameters, counted) * (1.0 + spec.space.away(point))

    return cost


def residuals_of(
    problem: Problem, spec: FitSpec, counted: Flags | None = None
) -> Callable[[Reals], Reals] | None:
    """Return what :func:`cost_of` is the root mean square of; nothing without a truth.

    Args:
        problem: What is fitted.
        spec: How.
        counted: Where errors count; as in the problem unless given.
    """
    if not problem.with_truth:
        return None
    where = np.flatnonzero(problem.counted if counted is None else counted)
    target = problem.target[where]

    base = numbers(replace(problem.base, spec.space.values(spec.space.point({}))))

    def residuals(point: Reals) -> Reals:
        parameters = numbers_with(base, spec.space.moved(point))
        error = joined(parameters, problem.recordings).value[where] - target
        return error * (1.0 + spec.space.away(point))

    return residuals


def search_of(
    problem: Problem,
    spec: FitSpec,
    start: Reals,
    evaluations: int,
    seed: tuple[int, ...],
    counted: Flags | None = None,
    steps: int = LEAST_SQUARES_STEPS,
) -> Search:
    """Return the search that continues from a good point.

    Args:
        problem: What is fitted.
        spec: How.
        start: The point.
        evaluations: How often the evolution may evaluate the cost.
        seed: Seed of the search.
        counted: Where errors count; as in the problem unless given.
        steps: Largest number of steps of least squares.
    """
    return Search(
        cost_of(problem, spec, counted),
        start,
        _FINAL_SPREAD,
        evaluations,
        seed,
        residuals_of(problem, spec, counted),
        steps,
    )


def fits(
    problem: Problem, specs: Sequence[FitSpec], pool: Pool, seed: Sequence[int]
) -> list[Minimum]:
    """Run several fits in parallel and return the best result of each.

    Args:
        problem: What is fitted.
        specs: How.
        pool: Where the fits run.
        seed: Seed of all of them.
    """
    first = [
        Search(
            cost_of(problem, spec),
            np.clip(spec.space.point(start), 0.02, 0.98),
            _START_SPREAD,
            spec.evaluations.start,
            (*seed, 0, k, number),
        )
        for k, spec in enumerate(specs)
        for number, start in enumerate(spec.starts)
    ]
    answers = iter(pool.run(first))
    begun = [
        sorted((next(answers) for _ in spec.starts), key=_cost)[: spec.evaluations.finalists]
        for spec in specs
    ]
    second = [
        search_of(problem, spec, each.point, spec.evaluations.finalist, (*seed, 1, k, number))
        for k, spec in enumerate(specs)
        for number, each in enumerate(begun[k])
    ]
    answers = iter(pool.run(second))
    return [min((next(answers) for _ in each), key=_cost) for each in begun]


def _cost(minimum: Minimum) -> float:
    return minimum.cost
