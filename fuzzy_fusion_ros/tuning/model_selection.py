# SPDX-License-Identifier: Apache-2.0
"""Cross-validation of the candidates, as a guard against over-fitting.

Chosen is the whole fusion unless something simpler does clearly better on blocks of the recording
that it was not fitted to, or as well with one sensor alone: a block left out often lacks what the
rules and the slope are for, so it says little in favour of going without them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.batch.cleaning import without_noise, without_spikes
from fuzzy_fusion_ros.batch.lag import read_through
from fuzzy_fusion_ros.batch.series import Series, seconds
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning.candidates import Candidate, candidates_for
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics
from fuzzy_fusion_ros.tuning.fit import FitSpec, Problem, cost_of, fits, plain_surprise
from fuzzy_fusion_ros.tuning.search import Minimum, Pool, Search
from fuzzy_fusion_ros.tuning.space import trusted

BLOCKS = 4
"""Parts of the recording, each of which is left out of one fit."""

CLEARLY_BETTER = 0.85
"""A simpler candidate is chosen if its error on unseen blocks is at most this share."""

S1_PAYS = 0.8
"""Without a truth, S1 must lower the surprise to this of what S2 alone predicts of itself, unless
its changes explain those of S2."""

ENOUGH_S2 = 50
"""With fewer samples of S2 the bias alone is learnt."""

RULES_PAY = 0.95
"""Without a truth, the rules must lower the surprise to this share."""

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
        surprise: How badly it predicts S2 on unseen blocks, unit of the signal; 0 with a truth.
    """

    name: str
    text: str
    parameters: Parameters
    fitted: float
    unseen: float
    unseen_blocks: tuple[float, ...]
    surprise: float = 0.0


def planned(sensors: Characteristics, with_truth: bool) -> int:
    """Return the largest number of evaluations of :func:`cross_validate`."""
    specs = [each.spec for each in candidates_for(sensors, with_truth)]
    return sum(each.planned + BLOCKS * each.evaluations.part for each in specs)


def cross_validate(
    problem: Problem, sensors: Characteristics, pool: Pool, seed: int
) -> list[FittedCandidate]:
    """Fit and cross-validate every candidate, the simplest first.

    Args:
        problem: What is fitted.
        sensors: What the sensors are like.
        pool: Where the fits run.
        seed: Seed of all of them.
    """
    candidates = candidates_for(sensors, problem.with_truth)
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
    found = [
        _validated(problem, candidate, fit, blocks, [next(answers) for _ in blocks])
        for candidate, fit in zip(candidates, best, strict=True)
    ]
    if problem.with_truth:
        return found
    alone = {"s1": _s1_surprise(problem.series, sensors), "s2": _s2_surprise(problem.series)}
    return [each._replace(surprise=alone.get(each.name, each.surprise)) for each in found]


def _s1_surprise(series: Series, sensors: Characteristics) -> float:
    """Return how badly S1, as it is, predicts S2 through its lag."""
    s1_s, s2_s = seconds(series)
    clean = without_noise(s1_s, without_spikes(series.s1)[0], sensors.s2_interval)
    return plain_surprise(read_through(trusted(sensors), s1_s, clean, s2_s) - series.s2)


def _s2_surprise(series: Series) -> float:
    """Return how badly S2 predicts itself: held, or along a straight line."""
    held = np.diff(series.s2)
    return min(plain_surprise(held), plain_surprise(np.diff(held)))


def chosen(
    candidates: Sequence[FittedCandidate],
    s2_samples: int,
    with_truth: bool = True,
    related: bool = True,
) -> FittedCandidate:
    """Return the candidate to take.

    Args:
        candidates: All of them.
        s2_samples: How many samples of S2 they were fitted to.
        with_truth: Whether to a truth; without, what counts is how well S2 is predicted.
        related: Whether changes of S1 explain those of S2.
    """
    named = {each.name: each for each in candidates}
    bias, slope, full = named["bias"], named["slope"], named["full"]
    best = bias if s2_samples < ENOUGH_S2 else full
    if not with_truth:
        if best is full and full.surprise > RULES_PAY * slope.surprise:
            best = slope
        if not related and best.surprise > S1_PAYS * named["s2"].surprise:
            return named["s2"]
        return named["s1"] if RULES_PAY * named["s1"].surprise <= best.surprise else best
    simpler = min((bias, slope, named["aggregator"]), key=_unseen)
    if simpler.unseen <= CLEARLY_BETTER * best.unseen:
        best = simpler
    sensor = min((named["s2"], named["s1"]), key=_unseen)
    return sensor if sensor.unseen <= best.unseen + TINY else best


def _unseen(candidate: FittedCandidate) -> float:
    return candidate.unseen


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
    surprise = 0.0
    if not problem.with_truth:
        surprise = _geometric_mean(
            [
                problem.surprise(_at(problem, candidate.spec, refit.point), block)
                for block, refit in zip(blocks, refits, strict=True)
            ]
        )
    parameters = _at(problem, candidate.spec, fit.point)
    return FittedCandidate(
        candidate.name,
        candidate.text,
        parameters,
        problem.misfit(parameters),
        float(np.sqrt(np.average(np.square(errors), weights=sizes))),
        tuple(errors),
        surprise,
    )


def _geometric_mean(values: list[float]) -> float:
    finite = [each for each in values if np.isfinite(each)]
    return float(np.exp(np.mean(np.log(finite)))) if finite else np.inf


def _at(problem: Problem, spec: FitSpec, point: Reals) -> Parameters:
    return replace(problem.base, spec.space.values(point))
