"""The guard against over-fitting: a ladder of settings, judged on unseen blocks.

The first setting wins that is within a few per cent of the best on blocks of the recording
that it was not fitted to. Either sensor alone is on the ladder, so what wins is no worse.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.core.parameter_tree import replace
from fuzzy_fusion_ros.core.parameters import Parameters
from fuzzy_fusion_ros.core.series import Reals
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics
from fuzzy_fusion_ros.tuning.fit import Flags, Problem, Setting, cost_of, fits
from fuzzy_fusion_ros.tuning.search import Found, Pool, Search
from fuzzy_fusion_ros.tuning.settings import Rung, rungs_for

BLOCKS = 4
"""Parts of the recording, each of which is left out of a fit once."""

CLOSE_TO_BEST = 1.03
"""A preferred setting may be this much worse on unseen blocks and still wins."""

_REFIT_SPREAD = 0.1


class Step(NamedTuple):
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


def planned(found: Characteristics) -> int:
    """Return how many evaluations climbing takes at most."""
    settings = [each.setting for each in rungs_for(found)]
    return sum(each.planned + BLOCKS * each.evaluations.part for each in settings)


def climb(problem: Problem, found: Characteristics, pool: Pool, seed: int) -> list[Step]:
    """Fit and judge every setting of the ladder, the preferred first.

    Args:
        problem: What is fitted.
        found: What the sensors are like.
        pool: Where it runs.
        seed: Seed of all of it.
    """
    rungs = rungs_for(found)
    best = fits(problem, [each.setting for each in rungs], pool, (seed, 0))
    blocks = blocks_of(problem.counted)
    searches = [
        Search(
            cost_of(problem, rung.setting, problem.counted & ~block),
            fit.point,
            _REFIT_SPREAD,
            rung.setting.evaluations.part,
            (seed, 1, number, k),
        )
        for number, (rung, fit) in enumerate(zip(rungs, best, strict=True))
        for k, block in enumerate(blocks)
    ]
    answers = iter(pool.run(searches))
    return [
        _judged(problem, rung, fit, blocks, [next(answers) for _ in blocks])
        for rung, fit in zip(rungs, best, strict=True)
    ]


def chosen(steps: list[Step]) -> Step:
    """Return the first setting that is about as good as the best on unseen blocks."""
    best = min(each.unseen for each in steps)
    return next(each for each in steps if each.unseen <= CLOSE_TO_BEST * best + TINY)


def blocks_of(counted: Flags) -> list[Flags]:
    """Split what counts into blocks with equally many samples each, in order of time."""
    number = np.cumsum(counted) * BLOCKS // max(int(np.count_nonzero(counted)) + 1, 1)
    return [counted & (number == k) for k in range(BLOCKS)]


def _judged(
    problem: Problem, rung: Rung, fit: Found, blocks: list[Flags], refits: list[Found]
) -> Step:
    errors = [
        problem.misfit(_at(problem, rung.setting, refit.point), block)
        for block, refit in zip(blocks, refits, strict=True)
    ]
    sizes = [np.count_nonzero(block) for block in blocks]
    parameters = _at(problem, rung.setting, fit.point)
    return Step(
        rung.name,
        rung.text,
        parameters,
        problem.misfit(parameters),
        float(np.sqrt(np.average(np.square(errors), weights=sizes))),
        tuple(errors),
    )


def _at(problem: Problem, setting: Setting, point: Reals) -> Parameters:
    return replace(problem.base, setting.space.values(point))
