"""Cross-validation of the candidates, as a guard against over-fitting.

Chosen is the first candidate whose error is within a few per cent of the least, on blocks of the
recording that it was not fitted to. Either sensor alone is a candidate, so the choice is no worse
than both.
"""

from __future__ import annotations

from collections.abc import Sequence
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
"""Parts of the recording, each of which is left out of one fit."""

CLOSE_TO_BEST = 1.03
"""A preferred candidate is chosen if its error on unseen blocks is within this of the least."""

_REFIT_SPREAD = 0.1


class FittedCandidate(NamedTuple):
    """A candidate, fitted and cross-validated; errors are root mean squares in the signal's unit.

    Attributes:
        name: Its name.
        text: What it does.
        parameters: The fusion's parameters, fitted to the whole recording.
        fitted: Error of these over the whole recording.
        unseen: Error over all blocks, in each with a fit to the others.
        unseen_blocks: That error in each block.
    """

    name: str
    text: str
    parameters: Parameters
    fitted: float
    unseen: float
    unseen_blocks: tuple[float, ...]


def planned(sensors: Characteristics) -> int:
    """Return the largest number of evaluations of :func:`cross_validate`."""
    specs = [each.spec for each in candidates_for(sensors)]
    return sum(each.planned + BLOCKS * each.evaluations.part for each in specs)


def cross_validate(
    problem: Problem, sensors: Characteristics, pool: Pool, seed: int
) -> list[FittedCandidate]:
    """Fit and cross-validate every candidate; the result is in order of preference.

    Args:
        problem: What is fitted.
        sensors: What the sensors are like.
        pool: Where the fits run.
        seed: Seed of all of them.
    """
    candidates = candidates_for(sensors)
    best = fits(problem, [each.spec for each in candidates], pool, (seed, 0))
    blocks = blocks_of(problem.counted)
    searches = [
        Search(
            cost_of(problem, candidate.spec, problem.counted & ~block),
            fit.point,
            _REFIT_SPREAD,
            candidate.spec.evaluations.part,
            (seed, 1, number, k),
        )
        for number, (candidate, fit) in enumerate(zip(candidates, best, strict=True))
        for k, block in enumerate(blocks)
    ]
    answers = iter(pool.run(searches))
    return [
        _validated(problem, candidate, fit, blocks, [next(answers) for _ in blocks])
        for candidate, fit in zip(candidates, best, strict=True)
    ]


def chosen(candidates: Sequence[FittedCandidate]) -> FittedCandidate:
    """Return the first candidate that is about as good as the best on unseen blocks."""
    least = min(each.unseen for each in candidates)
    return next(each for each in candidates if each.unseen <= CLOSE_TO_BEST * least + TINY)


def blocks_of(counted: Flags) -> list[Flags]:
    """Split what counts into consecutive blocks of equally many samples."""
    number = np.cumsum(counted) * BLOCKS // max(int(np.count_nonzero(counted)) + 1, 1)
    return [counted & (number == k) for k in range(BLOCKS)]


def _validated(
    problem: Problem, candidate: Candidate, fit: Minimum, blocks: list[Flags], refits: list[Minimum]
) -> FittedCandidate:
    errors = [
        problem.misfit(_at(problem, candidate.spec, refit.point), block)
        for block, refit in zip(blocks, refits, strict=True)
    ]
    sizes = [np.count_nonzero(block) for block in blocks]
    parameters = _at(problem, candidate.spec, fit.point)
    return FittedCandidate(
        candidate.name,
        candidate.text,
        parameters,
        problem.misfit(parameters),
        float(np.sqrt(np.average(np.square(errors), weights=sizes))),
        tuple(errors),
    )


def _at(problem: Problem, spec: FitSpec, point: Reals) -> Parameters:
    return replace(problem.base, spec.space.values(point))
