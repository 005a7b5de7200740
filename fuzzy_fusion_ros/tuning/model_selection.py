"""The guard against over-fitting: a ladder of settings, judged on unseen blocks.

The first setting wins that is within a few per cent of the best on blocks of the recording
that it was not fitted to. Either sensor alone is on the ladder, so what wins is no worse.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning.candidates import Candidate, candidates_for
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics
from fuzzy_fusion_ros.tuning.fit import FitSpec, Problem, cost_of, fits
from fuzzy_fusion_ros.tuning.search import Minimum, Pool, Search

BLOCKS = 4
"""Parts of the recording, each of which is left out of a fit once."""

CLOSE_TO_BEST = 1.03
"""A preferred setting may be this much worse on unseen blocks and still wins."""

_REFIT_SPREAD = 0.1


class FittedCandidate(NamedTuple):
    """A setting of the ladder, fitted and judged.

    Attributes:
        name: Its name.
        text: What it does.
        parameters: The fusion's parameters, fitted to the whole recording.
        fitted: Root mean square error there, unit of the signal.
        unseen: The same over blocks, each with a fit to the others.
        unseen_blocks: The same in each block; NaN where nothing counts.
    """

    name: str
    text: str
    parameters: Parameters
    fitted: float
    unseen: float
    unseen_blocks: tuple[float, ...]


def planned(sensors: Characteristics) -> int:
    """Return how many evaluations climbing takes at most."""
    settings = [each.setting for each in candidates_for(sensors)]
    return sum(each.planned + BLOCKS * each.evaluations.part for each in settings)


def cross_validate(
    problem: Problem, sensors: Characteristics, pool: Pool, seed: int
) -> list[FittedCandidate]:
    """Fit and judge every setting of the ladder, the preferred first.

    Args:
        problem: What is fitted.
        sensors: What the sensors are like.
        pool: Where it runs.
        seed: Seed of all of it.
    """
    candidates = candidates_for(sensors)
    best = fits(problem, [each.setting for each in candidates], pool, (seed, 0))
    blocks = blocks_of(problem.counted)
    searches = [
        Search(
            cost_of(problem, candidate.setting, problem.counted & ~block),
            fit.point,
            _REFIT_SPREAD,
            candidate.setting.evaluations.part,
            (seed, 1, number, k),
        )
        for number, (candidate, fit) in enumerate(zip(candidates, best, strict=True))
        for k, block in enumerate(blocks)
    ]
    answers = iter(pool.run(searches))
    return [
        _judged(problem, candidate, fit, blocks, [next(answers) for _ in blocks])
        for candidate, fit in zip(candidates, best, strict=True)
    ]


def chosen(steps: list[FittedCandidate]) -> FittedCandidate:
    """Return the first setting that is about as good as the best on unseen blocks."""
    best = min(each.unseen for each in steps)
    return next(each for each in steps if each.unseen <= CLOSE_TO_BEST * best + TINY)


def blocks_of(counted: Flags) -> list[Flags]:
    """Split what counts into blocks with equally many samples each, in order of time."""
    number = np.cumsum(counted) * BLOCKS // max(int(np.count_nonzero(counted)) + 1, 1)
    return [counted & (number == k) for k in range(BLOCKS)]


def _judged(
    problem: Problem, candidate: Candidate, fit: Minimum, blocks: list[Flags], refits: list[Minimum]
) -> FittedCandidate:
    errors = [
        problem.misfit(_at(problem, candidate.setting, refit.point), block)
        for block, refit in zip(blocks, refits, strict=True)
    ]
    sizes = [np.count_nonzero(block) for block in blocks]
    parameters = _at(problem, candidate.setting, fit.point)
    return FittedCandidate(
        candidate.name,
        candidate.text,
        parameters,
        problem.misfit(parameters),
        float(np.sqrt(np.average(np.square(errors), weights=sizes))),
        tuple(errors),
    )


def _at(problem: Problem, setting: FitSpec, point: Reals) -> Parameters:
    return replace(problem.base, setting.space.values(point))
