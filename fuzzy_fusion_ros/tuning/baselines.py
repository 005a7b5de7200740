# SPDX-License-Identifier: Apache-2.0
"""Fits the baselines by the same optimiser, to the same target, as the fusion."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple, cast

import numpy as np

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, baselines_for
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Series, run, values
from fuzzy_fusion_ros.parameters.group import Value, allowed, flatten, replace
from fuzzy_fusion_ros.tuning.characterise import TINY
from fuzzy_fusion_ros.tuning.search import Minimum, Pool, Progress, Search
from fuzzy_fusion_ros.tuning.space import Axis, Space, space_of

EVALUATIONS = 240
"""Evaluations of the evolution in a fit of more than ``FEW`` parameters; least squares end it."""

FEW = 3
"""A fit of no more parameters is by least squares from several starts."""

SHIFTS = (0.0, 0.15, -0.15)
"""Those starts, as distances from the derived parameters; more parameters are fitted from the
derived ones only."""

_SPREAD = 0.15

REACH = 1000.0
"""Largest factor by which a fit moves a parameter from its derived value, either way."""


class FittedBaselines(NamedTuple):
    """The baselines, fitted.

    Attributes:
        parameters: Of all of them.
        errors: Root mean square error of each by its name, unit of the signal.
    """

    parameters: BaselineParameters
    errors: Mapping[str, float]


class Attempt(NamedTuple):
    """One run of the optimiser for one baseline.

    Attributes:
        name: The baseline.
        parameters: Of all baselines, with the switches of this one set.
        space: What is moved.
        shift: Distance of the start from the derived parameters, along every axis.
        number: Its index among the attempts, for the seed.
    """

    name: str
    parameters: BaselineParameters
    space: Space
    shift: float
    number: int

    def at(self, point: Reals) -> BaselineParameters:
        """Return the parameters at a point."""
        return replace(self.parameters, self.space.values(point))


def fit_baselines(
    series: Series,
    target: Reals,
    counted: Flags,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = lambda done, of: None,
) -> FittedBaselines:
    """Fit every baseline to a target, starting from what :func:`baselines_for` derives.

    Args:
        series: The recording.
        target: The truth, or a reference in its place, at each S1 sample, shape (n,).
        counted: Where it counts, shape (n,); nowhere before the first sample of S2.
        seed: Seed of the optimiser.
        threads: How many searches run at a time; one for each processor unless given.
        progress: Called after every evaluation.
    """
    series = series.at_s1()
    warm_up(series)
    with Pool(threads, progress, planned()) as pool:
        return fit_baselines_in(pool, [series], target, counted, seed)


def planned() -> int:
    """Return the largest number of evaluations of all fits together."""

    def nothing(point: Reals) -> Reals:
        return point

    return sum(_search(each, nothing, 0).planned for each in attempts(BaselineParameters()))


def warm_up(series: Series) -> None:
    """Compile every baseline in this thread, so that the pool's threads do not wait."""
    short = series._replace(
        s1_ns=series.s1_ns[:2], s1=series.s1[:2], s2_known=np.minimum(series.s2_known[:2], 1)
    )
    for baseline in BASELINES.values():
        values(baseline.method(BaselineParameters()), short)


def fit_baselines_in(
    pool: Pool, recordings: Sequence[Series], target: Reals, counted: Flags, seed: int
) -> FittedBaselines:
    """Fit every baseline to all recordings in an existing pool; else as :func:`fit_baselines`."""
    derived = baselines_for(max(recordings, key=_samples))
    listed = list(attempts(derived))

    wanted = target[counted]

    def residuals_of(attempt: Attempt) -> Callable[[Reals], Reals]:
        baseline = BASELINES[attempt.name]

        def residuals(point: Reals) -> Reals:
            method = baseline.method(attempt.at(point))
            value = np.concatenate([values(method, each) for each in recordings])
            return value[counted] - wanted

        return residuals

    found = pool.run([_search(each, residuals_of(each), seed) for each in listed])
    best: dict[str, tuple[Minimum, Attempt]] = {}
    for fit, attempt in zip(found, listed, strict=True):
        if attempt.name not in best or fit.cost < best[attempt.name][0].cost:
            best[attempt.name] = fit, attempt
    parameters = derived
    for name, (fit, attempt) in best.items():
        switched = flatten(attempt.parameters)
        switches = {each: switched[each] for each in BASELINES[name].switches}
        parameters = replace(parameters, {**switches, **attempt.space.values(fit.point)})
        parameters = scaled_to_errors(parameters, name, recordings, wanted, counted)
    return FittedBaselines(parameters, {name: fit.cost for name, (fit, _) in best.items()})


def scaled_to_errors(
    parameters: BaselineParameters,
    name: str,
    recordings: Sequence[Series],
    wanted: Reals,
    counted: Flags,
) -> BaselineParameters:
    """Return the parameters with the noises of a filter scaled to its errors on the recordings.

    The scale allows for no optimism, because baselines are not cross-validated, whereas that of the
    fusion does: on a recording that neither was fitted to, this filter claims more than it should.

    Args:
        parameters: Of all baselines, fitted.
        name: The baseline; its parameters stay unless only ratios of its noises matter, or if
            they would have to leave their range.
        recordings: What it is fitted to.
        wanted: The target where it counts.
        counted: Where it counts, shape (n,).
    """
    noises = BASELINES[name].scaled
    if not noises:
        return parameters
    traces = [run(BASELINES[name].method(parameters), each) for each in recordings]
    error = np.concatenate([each.value for each in traces])[counted] - wanted
    deviation = np.concatenate([each.standard_deviation for each in traces])[counted]
    factor = root_mean_square(error / np.maximum(deviation, TINY))
    known = flatten(parameters)
    changes = {each: factor * float(cast(float, known[each])) for each in noises}
    if allowed(BaselineParameters, changes) != changes:
        return parameters
    return replace(parameters, changes)


def attempts(derived: BaselineParameters) -> Iterator[Attempt]:
    """Yield all attempts: every start of every baseline, for every combination of its switches."""
    number = 0
    for name, baseline in BASELINES.items():
        for states in itertools.product((False, True), repeat=len(baseline.switches)):
            switched = replace(derived, dict(zip(baseline.switches, states, strict=True)))
            axes = [_axis(each, flatten(derived)[each]) for each in baseline.moved]
            space = space_of(BaselineParameters, axes, {})
            for shift in SHIFTS if 0 < len(axes) <= FEW else SHIFTS[:1]:
                yield Attempt(name, switched, space, shift, number)
                number += 1


def _search(attempt: Attempt, residuals: Callable[[Reals], Reals], seed: int) -> Search:
    """Return the search of an attempt, given its errors at each sample that counts."""
    return Search(
        lambda point: root_mean_square(residuals(point)),
        np.clip(attempt.space.point({}) + attempt.shift, 0.0, 1.0),
        _SPREAD,
        EVALUATIONS if len(attempt.space.axes) > FEW else 1,
        (seed, 2, attempt.number),
        residuals,
    )


def _samples(series: Series) -> int:
    return int(series.s2.size)


def _axis(name: str, value: Value) -> Axis:
    usual = float(cast(float, value))  # baselines have numbers only
    if name.endswith(".weight"):
        return Axis(name, 0.0, 1.0, usual, logarithmic=False)
    return Axis(name, usual / REACH, usual * REACH, usual)
