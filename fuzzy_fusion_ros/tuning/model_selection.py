# SPDX-License-Identifier: Apache-2.0
"""Cross-validation of the candidates, as a guard against over-fitting.

Chosen is the simplest candidate that does about as well as the best on parts of the recording that
it was not fitted to. The parts are four blocks, or of several recordings each one.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps
from fuzzy_fusion_ros.batch.cleaning import without_noise, without_spikes
from fuzzy_fusion_ros.batch.lag import read_through
from fuzzy_fusion_ros.batch.series import Series, seconds
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning.candidates import Candidate, candidates_for
from fuzzy_fusion_ros.tuning.characterise import TINY, Characteristics
from fuzzy_fusion_ros.tuning.fit import (
    REFIT_STEPS,
    FitSpec,
    Problem,
    fits,
    plain_surprise,
    search_of,
)
from fuzzy_fusion_ros.tuning.kernel import joined
from fuzzy_fusion_ros.tuning.search import Minimum, Pool
from fuzzy_fusion_ros.tuning.space import trusted

BLOCKS = 4
"""Parts of a single recording."""

MOST_FOLDS = 8
"""Each part is left out of one fit; of more recordings than this, every eighth at a time."""

AS_GOOD = 1.1
"""A simpler candidate is chosen if its error on unseen parts is at most this factor larger, as four
parts do not tell it more precisely; without a truth, the surprise counts in place of the error."""

ALONE_AS_GOOD = 1.05
"""Without a truth, S1 alone is chosen if its surprise is at most this factor larger."""

OBSERVERS = ("bias", "slope", "full")
"""Candidates that learn S1's bias, the simplest first."""

S1_PAYS = 0.8
"""Without a truth, S1 must lower the surprise to this of what S2 alone predicts of itself, unless
its changes explain those of S2."""

ENOUGH_S2 = 50
"""With fewer samples of S2, too few to fit rules to, ``bias`` is chosen unless a sensor alone is no
worse; its time constant is not shortened, the predictor stays off, and without a truth the outcome
has a warning."""


class FittedCandidate(NamedTuple):
    """A candidate, fitted and cross-validated; errors are root mean squares in the signal's unit.

    Attributes:
        name: Its name.
        text: What it does.
        parameters: The fusion's parameters, fitted to the whole recording.
        fitted: Error of these over the whole recording.
        unseen: Error over all parts, in each with a fit to the others.
        unseen_parts: That error in each part.
        surprise: How badly it predicts S2 on unseen parts, unit of the signal; 0 with a truth.
    """

    name: str
    text: str
    parameters: Parameters
    fitted: float
    unseen: float
    unseen_parts: tuple[float, ...]
    surprise: float = 0.0

    @property
    def unseen_loss(self) -> float:
        """What a choice lowers: the surprise, or with a truth the error, on unseen parts."""
        return self.surprise or self.unseen


def planned(sensors: Characteristics, with_truth: bool, parts: int) -> int:
    """Return the largest number of evaluations of :func:`cross_validate`.

    Args:
        sensors: What the sensors are like.
        with_truth: Whether the target is a truth.
        parts: Number of parts.
    """
    specs = [each.spec for each in candidates_for(sensors, with_truth)]
    return sum(each.planned(with_truth, min(parts, MOST_FOLDS)) for each in specs)


def cross_validate(
    problem: Problem, sensors: Characteristics, pool: Pool, seed: int
) -> list[FittedCandidate]:
    """Fit and cross-validate every candidate, in the order of the table.

    Args:
        problem: What is fitted.
        sensors: What the sensors are like.
        pool: Where the fits run.
        seed: Seed of all of them.
    """
    candidates = candidates_for(sensors, problem.with_truth)
    best = fits(problem, [each.spec for each in candidates], pool, (seed, 0))
    found = _cross_validated(problem, candidates, best, pool, (seed, 1))
    if problem.with_truth:
        return found
    s1 = [_s1_errors(each, sensors) for each in problem.recordings]
    alone = {"s1": plain_surprise(np.concatenate(s1)), "s2": _s2_surprise(problem.recordings)}
    return [each._replace(surprise=alone.get(each.name, each.surprise)) for each in found]


def refitted(
    problem: Problem, candidate: Candidate, start: Parameters, pool: Pool, seed: int
) -> FittedCandidate:
    """Fit and cross-validate a candidate again, from a good start, for another base.

    Args:
        problem: What is fitted, with that base.
        candidate: The candidate.
        start: Parameters near the best.
        pool: Where the fits run.
        seed: Seed of all of them.
    """
    spec = candidate.spec
    point = spec.space.point_of(start)
    search = search_of(problem, spec, point, spec.evaluations.part, (seed, 3), steps=REFIT_STEPS)
    return _cross_validated(problem, [candidate], pool.run([search]), pool, (seed, 4))[0]


def _cross_validated(
    problem: Problem,
    candidates: Sequence[Candidate],
    best: Sequence[Minimum],
    pool: Pool,
    seed: tuple[int, ...],
) -> list[FittedCandidate]:
    """Fit every candidate, from the best fit of it to all parts, to all but each part."""
    parts = parts_of(problem)
    folds = folds_of(parts)
    searches = [
        search_of(
            problem,
            candidate.spec,
            fit.point,
            candidate.spec.evaluations.part,
            (*seed, number, k),
            problem.counted & ~fold,
            REFIT_STEPS,
        )
        for number, (candidate, fit) in enumerate(zip(candidates, best, strict=True))
        for k, fold in enumerate(folds)
    ]
    answers = iter(pool.run(searches))
    return [
        _validated(problem, candidate, fit, parts, [next(answers) for _ in folds])
        for candidate, fit in zip(candidates, best, strict=True)
    ]


def _s1_errors(series: Series, sensors: Characteristics) -> Reals:
    """Return how far S2 is from what S1, as it is, predicts of it through its lag."""
    s1_s, s2_s = seconds(series)
    clean = without_noise(s1_s, without_spikes(series.s1)[0], sensors.s2_interval)
    return read_through(trusted(sensors), s1_s, clean, s2_s) - series.s2


def _s2_surprise(recordings: Sequence[Series]) -> float:
    """Return how badly S2 predicts itself: held, or along a straight line."""
    return min(
        plain_surprise(np.concatenate([np.diff(each.s2, order) for each in recordings]))
        for order in (1, 2)
    )


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
    names = OBSERVERS[:1] if s2_samples < ENOUGH_S2 else OBSERVERS
    observers = [named[each] for each in names]
    if not with_truth:
        best = _simplest(observers)
        if not related and best.surprise > S1_PAYS * named["s2"].surprise:
            return named["s2"]
        return named["s1"] if named["s1"].surprise <= ALONE_AS_GOOD * best.surprise else best
    others = [named["aggregator"]] if len(names) > 1 else []
    best = _simplest([*observers, *others])
    sensor = min((named["s2"], named["s1"]), key=lambda each: each.unseen)
    return sensor if sensor.unseen <= best.unseen + TINY else best


def _simplest(candidates: Sequence[FittedCandidate]) -> FittedCandidate:
    """Return the first candidate that is as good as the best of them."""
    most = AS_GOOD * min(each.unseen_loss for each in candidates)
    return next(each for each in candidates if each.unseen_loss <= most)


def parts_of(problem: Problem) -> Stamps:
    """Return which part each sample belongs to, -1 where it does not count, shape (n,).

    A part is a recording, or of a single one a block; blocks are consecutive, and as many samples
    count in each.
    """
    counted = problem.counted
    if len(problem.recordings) > 1:
        sizes = [each.s1.size for each in problem.recordings]
        number = np.repeat(np.arange(len(sizes)), sizes)
    else:
        number = np.cumsum(counted) * BLOCKS // max(int(np.count_nonzero(counted)) + 1, 1)
    return np.where(counted, number, -1)


def folds_of(parts: Stamps) -> list[Flags]:
    """Return for each fit what is left out of it, shape (n,).

    Args:
        parts: As from :func:`parts_of`.
    """
    folds = min(int(parts.max()) + 1, MOST_FOLDS)
    return [(parts >= 0) & (parts % folds == k) for k in range(folds)]


def errors_by_part(errors: Reals, parts: Stamps) -> Reals:
    """Return the root mean square of errors in each part, shape (number of parts,).

    Args:
        errors: Shape (n,); what they are where they do not count does not matter.
        parts: As from :func:`parts_of`.
    """
    counted = parts >= 0
    own = parts[counted]
    mean: Reals = np.bincount(own, np.square(errors[counted])) / np.bincount(own)
    return np.sqrt(mean)


def _validated(
    problem: Problem, candidate: Candidate, fit: Minimum, parts: Stamps, refits: list[Minimum]
) -> FittedCandidate:
    sizes = np.bincount(parts[parts >= 0])
    errors = np.empty(sizes.size)
    surprises = []
    for k, (refit, fold) in enumerate(zip(refits, folds_of(parts), strict=True)):
        refitted = _at(problem, candidate.spec, refit.point)
        value = joined(refitted, problem.recordings).value
        errors[k :: len(refits)] = errors_by_part(value - problem.target, parts)[k :: len(refits)]
        if not problem.with_truth:
            surprises.append(problem.surprise(refitted, fold))
    parameters = _at(problem, candidate.spec, fit.point)
    return FittedCandidate(
        candidate.name,
        candidate.text,
        parameters,
        problem.misfit(parameters),
        float(np.sqrt(np.average(np.square(errors), weights=sizes))),
        tuple(errors.tolist()),
        _geometric_mean(surprises) if surprises else 0.0,
    )


def _geometric_mean(values: list[float]) -> float:
    finite = [each for each in values if np.isfinite(each)]
    return float(np.exp(np.mean(np.log(finite)))) if finite else np.inf


def _at(problem: Problem, spec: FitSpec, point: Reals) -> Parameters:
    return replace(problem.base, spec.space.values(point))
