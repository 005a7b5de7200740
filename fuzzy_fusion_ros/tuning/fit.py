"""Fitting a set of parameters to a target, by a few starts and the two best of them."""

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
"""So many of the starts are followed to the end."""

_START_SPREAD = 0.12
_FINAL_SPREAD = 0.1


class Problem(NamedTuple):
    """What is fitted, and to what.

    Attributes:
        series: The recording.
        target: The signal, at each S1 sample, shape (n,).
        counted: Where it counts, shape (n,).
        base: All parameters that a fit leaves alone.
    """

    series: Series
    target: Reals
    counted: Flags
    base: Parameters

    def misfit(self, parameters: Parameters, counted: Flags | None = None) -> float:
        """Return the root mean square error of the estimator, without predictor.

        Args:
            parameters: What it runs with.
            counted: Where errors count; where the problem says unless given.
        """
        where = self.counted if counted is None else counted
        return root_mean_square(outputs(parameters, self.series).value[where] - self.target[where])


class Evaluations(NamedTuple):
    """How often the optimiser may ask for the misfit.

    Attributes:
        start: From each start.
        finalist: From each of the best of these.
        part: In each fit to a part of the recording.
    """

    start: int
    finalist: int
    part: int


class FitSpec(NamedTuple):
    """A structure to fit: what may move, from where, and where to when in doubt.

    Attributes:
        space: What moves.
        starts: Values to start from, by dotted name, shares as shares.
        home: Values to which parameters are drawn that make no difference.
        pull: How much a unit of squared distance from home costs, as a share of the misfit.
        evaluations: What a fit of it may take.
    """

    space: Space
    starts: Sequence[Mapping[str, float]]
    home: Mapping[str, float]
    pull: float
    evaluations: Evaluations

    @property
    def planned(self) -> int:
        """Evaluations that a fit takes at most."""
        starts, finalists = len(self.starts), min(FINALISTS, len(self.starts))
        return starts * self.evaluations.start + finalists * self.evaluations.finalist


def cost_of(
    problem: Problem, setting: FitSpec, counted: Flags | None = None
) -> Callable[[Reals], float]:
    """Return what a fit makes small: the misfit, more the further from home it is.

    Args:
        problem: What is fitted.
        setting: How.
        counted: Where errors count; where the problem says unless given.
    """
    home = setting.space.point(setting.home)

    def cost(point: Reals) -> float:
        parameters = replace(problem.base, setting.space.values(point))
        away = float(np.sum(np.square(point - home)))
        return problem.misfit(parameters, counted) * (1.0 + setting.pull * away)

    return cost


def fits(
    problem: Problem, settings: Sequence[FitSpec], pool: Pool, seed: Sequence[int]
) -> list[Minimum]:
    """Fit several settings side by side; the best of each.

    Args:
        problem: What is fitted.
        settings: How.
        pool: Where it runs.
        seed: Seed of all of it.
    """
    costs = [cost_of(problem, each) for each in settings]
    first = [
        Search(
            costs[k],
            np.clip(setting.space.point(start), 0.02, 0.98),
            _START_SPREAD,
            setting.evaluations.start,
            (*seed, 0, k, number),
        )
        for k, setting in enumerate(settings)
        for number, start in enumerate(setting.starts)
    ]
    answers = iter(pool.run(first))
    begun = [[next(answers) for _ in setting.starts] for setting in settings]
    second = [
        Search(
            costs[k], each.point, _FINAL_SPREAD, setting.evaluations.finalist, (*seed, 1, k, number)
        )
        for k, setting in enumerate(settings)
        for number, each in enumerate(sorted(begun[k], key=_cost)[:FINALISTS])
    ]
    answers = iter(pool.run(second))
    ended = [[next(answers) for _ in each[:FINALISTS]] for each in begun]
    return [min(each, key=_cost) for each in ended]


def _cost(minimum: Minimum) -> float:
    return minimum.cost
