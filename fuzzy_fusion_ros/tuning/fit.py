"""Fitting parameters to a target: a short search from several starts, a long one from the best."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning.kernel import outputs
from fuzzy_fusion_ros.tuning.search import Minimum, Pool, Search
from fuzzy_fusion_ros.tuning.space import Space

FINALISTS = 2
"""Number of starts from which the search is continued."""

_START_SPREAD = 0.12
_FINAL_SPREAD = 0.1


class Problem(NamedTuple):
    """What is fitted, and to what.

    Attributes:
        series: The recording.
        target: The signal, at each S1 sample, shape (n,).
        counted: Where it counts, shape (n,).
        base: Parameters; a fit changes only those in its space.
    """

    series: Series
    target: Reals
    counted: Flags
    base: Parameters

    def misfit(self, parameters: Parameters, counted: Flags | None = None) -> float:
        """Return the root mean square error of the estimator without its predictor.

        Args:
            parameters: Of the estimator.
            counted: Where errors count; as in the problem unless given.
        """
        where = self.counted if counted is None else counted
        return root_mean_square(outputs(parameters, self.series).value[where] - self.target[where])


class Evaluations(NamedTuple):
    """How often the optimiser may evaluate the misfit.

    Attributes:
        start: From each start.
        finalist: From each of the best of these.
        part: In each fit to a part of the recording.
    """

    start: int
    finalist: int
    part: int


class FitSpec(NamedTuple):
    """What a fit moves, where it starts, and where parameters go that make no difference.

    Attributes:
        space: What moves.
        starts: Values to start from, by dotted name; shares as shares.
        home: Values towards which parameters are drawn.
        pull: Cost of a unit of squared distance from home, as a share of the misfit.
        evaluations: How many evaluations a fit may take.
    """

    space: Space
    starts: Sequence[Mapping[str, float]]
    home: Mapping[str, float]
    pull: float
    evaluations: Evaluations

    @property
    def planned(self) -> int:
        """Largest number of evaluations of a fit."""
        starts, finalists = len(self.starts), min(FINALISTS, len(self.starts))
        return starts * self.evaluations.start + finalists * self.evaluations.finalist


def cost_of(
    problem: Problem, spec: FitSpec, counted: Flags | None = None
) -> Callable[[Reals], float]:
    """Return what a fit minimises: the misfit, increased with the distance from home.

    Args:
        problem: What is fitted.
        spec: How.
        counted: Where errors count; as in the problem unless given.
    """
    home = spec.space.point(spec.home)

    def cost(point: Reals) -> float:
        parameters = replace(problem.base, spec.space.values(point))
        away = float(np.sum(np.square(point - home)))
        return problem.misfit(parameters, counted) * (1.0 + spec.pull * away)

    return cost


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
    costs = [cost_of(problem, each) for each in specs]
    first = [
        Search(
            costs[k],
            np.clip(spec.space.point(start), 0.02, 0.98),
            _START_SPREAD,
            spec.evaluations.start,
            (*seed, 0, k, number),
        )
        for k, spec in enumerate(specs)
        for number, start in enumerate(spec.starts)
    ]
    answers = iter(pool.run(first))
    begun = [[next(answers) for _ in spec.starts] for spec in specs]
    second = [
        Search(
            costs[k], each.point, _FINAL_SPREAD, spec.evaluations.finalist, (*seed, 1, k, number)
        )
        for k, spec in enumerate(specs)
        for number, each in enumerate(sorted(begun[k], key=_cost)[:FINALISTS])
    ]
    answers = iter(pool.run(second))
    ended = [[next(answers) for _ in each[:FINALISTS]] for each in begun]
    return [min(each, key=_cost) for each in ended]


def _cost(minimum: Minimum) -> float:
    return minimum.cost
