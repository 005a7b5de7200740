# SPDX-License-Identifier: Apache-2.0
"""Tuning: characterise the sensors, choose a target, cross-validate candidates, fit baselines."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines import BaselineParameters, methods
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Method, Series, fusion, run, values
from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import allowed, flatten, replace
from fuzzy_fusion_ros.self_tuning.homes import safety_net
from fuzzy_fusion_ros.tuning import baselines, model_selection
from fuzzy_fusion_ros.tuning.candidates import Candidate, candidates_for
from fuzzy_fusion_ros.tuning.characterise import (
    FEWEST_S1,
    TINY,
    Characteristics,
    characterise,
)
from fuzzy_fusion_ros.tuning.errors import TuneError
from fuzzy_fusion_ros.tuning.fit import Problem
from fuzzy_fusion_ros.tuning.kernel import joined, outputs
from fuzzy_fusion_ros.tuning.model_selection import FittedCandidate
from fuzzy_fusion_ros.tuning.reference import reference_without_truth
from fuzzy_fusion_ros.tuning.search import Pool, Progress
from fuzzy_fusion_ros.tuning.space import LAGS, has_lag_to_fit
from fuzzy_fusion_ros.tuning.together import oddities, typical

NO_WORSE = 1.002
"""What makes the method simpler or safer may increase the misfit by up to this factor: a step of it
that is switched off, the safety net that is set."""

INSTANT = 0.1
"""Below this share of S2's interval, learning is as good as instant."""

SHORTENING_COSTS = 1.02
"""Shortening the bias's time constant may increase the misfit by up to this factor."""

OUTLIER_THRESHOLD = 4.0
"""Fits bound innovations of S2 at this many of their standard deviations unless a threshold above 0
is given: of normal ones, one in 16,000 is beyond it."""

BOUNDING_COSTS = 1.02
"""Bounding innovations of S2 may increase the misfit by up to this factor."""

ADAPTING_PAYS = 0.9
"""Adaptation is switched on if it lowers the misfit to this share, at once and on unseen parts."""

ADAPTATIONS = MappingProxyType(
    {"adapt.scale_time_constant": 100.0, "adapt.lag_time_constant": 10.0}
)
"""What is tried, with its time constant in intervals of S2."""

MOST_DOUBLINGS = 12
"""A safety net that still does harm after this many doublings is not set."""

UNSEEN = 1.5
"""Without a truth, errors are larger by this than what S2's innovations show, and by the ratio of
the misfit on the worst unseen part to that fitted."""

DIGITS = 4
"""Significant digits of fitted values."""

S1_PATIENCE = 10.0
"""S1 counts as lost after this many of its intervals, or later if so given."""

BETTER_BY = 0.97
"""The predictor is switched on if it lowers the error to this share."""

_LOW_PASSES = (0.3, 100.0, 20)
"""Shortest, longest and number of time constants to try, in intervals of S1."""

WITHIN = (0.70, 0.94)
"""At least these shares of the errors are within one and two standard deviations, midway between
too few (0.55, 0.88) and too many (0.85, 1). Few errors that are large do not change them."""

_FLOORS = (0.0, *(2.0**power for power in range(-4, 3)))
"""What of S1's noise may come through, in multiples of the error."""

_TOLERANCES = (0.3, 1.0, 3.0)
"""Tolerances of the gate to try, in multiples of the error without predictor."""


class Trial(NamedTuple):
    """A recording to fit to.

    Attributes:
        series: The recording.
        truth: At each S1 sample, shape (n,), NaN where unknown; without it a reference is made.
        name: What errors call it; a single recording needs none.
        clocks_agree: Whether one clock stamps both sensors, as far as is known.
    """

    series: Series
    truth: Reals | None = None
    name: str = ""
    clocks_agree: bool = True


class OnRecording(NamedTuple):
    """How a fit does on one recording; errors are root mean squares in the signal's unit.

    Attributes:
        target: What the fit is to, at each S1 sample, shape (n,), NaN where unknown.
        counted: Where the target counts, shape (n,).
        before_error: Error of the parameters before.
        error: Error of the parameters after.
        unseen_error: Error of a fit of the chosen candidate to other recordings; of a single
            recording, to other parts of it.
        baseline_errors: Error of each baseline by its name.
        oddities: In which respects its sensors are not those of the other recordings.
    """

    target: Reals
    counted: Flags
    before_error: float
    error: float
    unseen_error: float
    baseline_errors: dict[str, float]
    oddities: tuple[str, ...]


class Tuned(NamedTuple):
    """Result of tuning; errors are root mean squares in the signal's unit, over all recordings.

    Attributes:
        sensors: What the sensors are like.
        s2_samples: How many samples of S2 there are.
        with_truth: Whether the target is a truth.
        target: What the fits are to, at each S1 sample, shape (n,), NaN where unknown.
        counted: Where the target counts, shape (n,).
        candidates: The candidates as fitted, in the order of the table.
        chosen: Name of the one that was chosen.
        at_limit: Times that ended at the upper end of their search range, by dotted name.
        before: The parameters before.
        before_error: Their error.
        parameters: The parameters after.
        error: Their error.
        baselines: Parameters of the baselines, fitted by the same optimiser.
        baseline_errors: Error of each baseline by its name.
        recordings: How the fit does on each recording, in their order.
        truth_is_wrong: Whether a truth does not suit the sensors, as far as is known.
    """

    sensors: Characteristics
    s2_samples: int
    with_truth: bool
    target: Reals
    counted: Flags
    candidates: tuple[FittedCandidate, ...]
    chosen: str
    at_limit: tuple[str, ...]
    before: Parameters
    before_error: float
    parameters: Parameters
    error: float
    baselines: BaselineParameters
    baseline_errors: dict[str, float]
    recordings: tuple[OnRecording, ...]
    truth_is_wrong: bool = False

    def on(self, k: int) -> Tuned:
        """Return the result with target and errors of the fusion on the k-th recording alone."""
        own = self.recordings[k]
        return self._replace(
            target=own.target,
            counted=own.counted,
            before_error=own.before_error,
            error=own.error,
            recordings=(own,),
        )


def tune(
    series: Series,
    truth: Reals | None = None,
    parameters: Parameters | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = lambda done, of: None,
) -> Tuned:
    """Fit the fusion and the baselines to one recording; otherwise as :func:`tune_to`.

    Args:
        series: The recording.
        truth: As in :class:`Trial`.
        parameters: As in :func:`tune_to`.
        seed: As in :func:`tune_to`.
        threads: As in :func:`tune_to`.
        progress: As in :func:`tune_to`.

    Raises:
        TuneError: There is too little to fit to.
    """
    return tune_to([Trial(series, truth)], parameters, seed, threads, progress)


def tune_to(
    trials: Sequence[Trial],
    parameters: Parameters | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = lambda done, of: None,
) -> Tuned:
    """Fit the fusion and the baselines to one or several recordings.

    The same arguments give the same result, whatever the number of threads.

    Args:
        trials: The recordings; all of them with a truth, or none.
        parameters: Values of what a fit does not move; the defaults unless given.
        seed: Seed of the optimiser.
        threads: How many searches run at a time; one for each processor unless given.
        progress: Called after every evaluation.

    Raises:
        TuneError: There is too little to fit to.
    """
    begun = [_begun(each) for each in trials]
    before = parameters or Parameters()
    sensors = typical([each.sensors for each in begun])
    threshold = before.s2.outlier_threshold or OUTLIER_THRESHOLD
    base = replace(before, {"self_tuning": False, "s2.outlier_threshold": threshold})
    if before.s1.timeout > 0.0:  # else it is automatic
        patience = {"s1.timeout": max(before.s1.timeout, S1_PATIENCE * sensors.s1_interval)}
        base = replace(base, allowed(Parameters, patience))
    with_truth = all(each.truth is not None for each in trials)
    problem = Problem(
        [each.series for each in begun],
        np.concatenate([each.target for each in begun]),
        np.concatenate([each.counted for each in begun]),
        base,
        with_truth,
    )
    first = problem.recordings[0]
    outputs(base, first)  # compiles it in this thread, so that the pool's threads do not wait
    baselines.warm_up(first)
    parts = int(model_selection.parts_of(problem).max()) + 1
    planned = model_selection.planned(sensors, with_truth, parts) + baselines.planned()
    with Pool(threads, progress, planned) as pool:
        candidates = model_selection.cross_validate(problem, sensors, pool, seed)
        fitted = baselines.fit_baselines_in(
            pool, problem.recordings, problem.target, problem.counted, seed
        )
    s2_samples = sum(int(each.s2_known[-1]) for each in problem.recordings)
    is_long = s2_samples >= model_selection.ENOUGH_S2
    best = model_selection.chosen(candidates, s2_samples, with_truth, sensors.related)
    named = {each.name: each for each in candidates_for(sensors, with_truth)}
    if before.s2.outlier_threshold <= 0.0:
        best = bounded_if_cheap(problem, named[best.name], best, threads, seed)
    best = adapting_if_better(problem, named[best.name], best, sensors, threads, seed)
    final = best.parameters
    if with_truth:
        final = simplified(problem, sensors, final)
        if is_long:  # else it does not show what that costs
            final = shorten_bias_time_constant(problem, final)
    elif sensors.related:
        final = with_low_pass(problem, sensors, final)
    final = with_safety_net(problem, final)
    after = rounded(problem, replace(final, {"predictor.enabled": False}))
    if is_long:
        after = with_predictor(problem, after)
    worse = max(1.0, max(best.unseen_parts) / max(best.fitted, TINY))
    if with_truth:
        after = rounded(problem, with_deviation(problem, after, math.sqrt(worse)))
    else:
        after = rounded(problem, with_assumed_deviation(sensors, after, UNSEEN * worse))
    unseen = best.unseen_parts if len(begun) > 1 else (best.unseen,)
    before_errors, after_errors = (errors_of(problem, each) for each in (before, after))
    baseline_errors = {
        name: method_errors(problem, method) for name, method in methods(fitted.parameters).items()
    }
    return Tuned(
        sensors=sensors,
        s2_samples=s2_samples,
        with_truth=with_truth,
        target=problem.target,
        counted=problem.counted,
        candidates=tuple(best if each.name == best.name else each for each in candidates),
        chosen=best.name,
        at_limit=named[best.name].spec.space.at_limit(after),
        before=before,
        before_error=error_of(problem, before),
        parameters=after,
        error=error_of(problem, after),
        baselines=fitted.parameters,
        baseline_errors=dict(fitted.errors),
        recordings=tuple(
            OnRecording(
                target=each.target,
                counted=each.counted,
                before_error=before_errors[k],
                error=after_errors[k],
                unseen_error=unseen[k],
                baseline_errors={name: errors[k] for name, errors in baseline_errors.items()},
                oddities=tuple(oddities(each.sensors, sensors)),
            )
            for k, each in enumerate(begun)
        ),
    )


def why_unusable(trial: Trial) -> str:
    """Return why nothing can be fitted to a recording, in words; empty where that is possible.

    Args:
        trial: The recording.
    """
    try:
        _begun(trial)
    except TuneError as error:
        return str(error)
    return ""


class _Begun(NamedTuple):
    """A recording, characterised, and what to fit to."""

    series: Series
    sensors: Characteristics
    target: Reals
    counted: Flags


def _begun(trial: Trial) -> _Begun:
    series = trial.series.at_s1()
    try:
        sensors = characterise(series)._replace(clocks_agree=trial.clocks_agree)
        target = reference_without_truth(series, sensors) if trial.truth is None else trial.truth
        counted = (series.s2_known > 0) & np.isfinite(target)
        if np.count_nonzero(counted) < FEWEST_S1:
            raise TuneError(
                f"got {np.count_nonzero(counted)} samples of S1 within the span of the truth, "
                f"expected at least {FEWEST_S1}: check that their stamps overlap"
            )
    except TuneError as error:
        raise TuneError(f"{trial.name}: {error}" if trial.name else str(error)) from None
    return _Begun(series, sensors, target, counted)


def bounded_if_cheap(
    problem: Problem,
    candidate: Candidate,
    fitted: FittedCandidate,
    threads: int | None,
    seed: int,
) -> FittedCandidate:
    """Remove the bound on S2's innovations if it costs too much, and then fit without it.

    Garbage of S2 is often missing from a recording, and correct samples of it are seldom far off.

    Args:
        problem: What was fitted.
        candidate: The candidate.
        fitted: The fit of it; without the observer there is nothing to bound.
        threads: As in :func:`tune_to`.
        seed: Seed of the second fit, which is cross-validated as the first.
    """
    bounded = fitted.parameters
    unbounded = replace(bounded, {"s2.outlier_threshold": 0.0})
    if not bounded.s1.bias_time_constant > 0.0:
        return fitted._replace(parameters=unbounded)
    if problem.misfit(bounded) <= BOUNDING_COSTS * problem.misfit(unbounded):
        return fitted
    free = problem._replace(base=replace(problem.base, {"s2.outlier_threshold": 0.0}))
    # rare and short, so that progress, which is complete by now, does not count it
    with Pool(threads, lambda done, of: None, 0) as pool:
        return model_selection.refitted(free, candidate, unbounded, pool, seed)


def adapting_if_better(
    problem: Problem,
    candidate: Candidate,
    fitted: FittedCandidate,
    sensors: Characteristics,
    threads: int | None,
    seed: int,
) -> FittedCandidate:
    """Adapt S1's scale, and S2's lag, if each pays, and then fit with that.

    Args:
        problem: What was fitted.
        candidate: The candidate.
        fitted: The fit of it; without the observer there is nothing to adapt.
        sensors: What the sensors are like.
        threads: As in :func:`tune_to`.
        seed: Seed of the further fits, which are cross-validated as the first.
    """
    for name, intervals in ADAPTATIONS.items():
        fixed = fitted.parameters
        change = allowed(Parameters, {name: intervals * sensors.s2_interval})
        if flatten(fixed)[name] != 0.0 or not fixed.s1.bias_time_constant > 0.0:
            continue
        # A fit without may have gone where adaptation cannot follow, as to no lag.
        suggested = candidate.spec.space.values(candidate.spec.space.point({}))
        starts = [replace(each, change) for each in (fixed, replace(fixed, suggested))]
        adapting = min(starts, key=problem.loss)
        if problem.loss(adapting) > ADAPTING_PAYS * problem.loss(fixed):
            continue
        with Pool(threads, lambda done, of: None, 0) as pool:  # rare, as above
            again = model_selection.refitted(
                problem._replace(base=adapting), candidate, adapting, pool, seed
            )
        if again.unseen_loss <= ADAPTING_PAYS * fitted.unseen_loss:
            fitted = again
    return fitted


def with_low_pass(problem: Problem, sensors: Characteristics, parameters: Parameters) -> Parameters:
    """Fit the low-pass to the reference: S2, which is slow, hardly sees what S1's noise does.

    Args:
        problem: What was fitted.
        sensors: What the sensors are like.
        parameters: The result; it stays as it is unless the bias is learnt.
    """
    if not parameters.s1.bias_time_constant > 0.0:
        return parameters
    times = sensors.s1_interval * np.geomspace(*_LOW_PASSES)
    tried = [
        replace(parameters, allowed(Parameters, {"s1.lowpass_time_constant": float(each)}))
        for each in (0.0, *times)
    ]
    return min(tried, key=problem.misfit)


def simplified(problem: Problem, sensors: Characteristics, parameters: Parameters) -> Parameters:
    """Switch off every step of the method that makes no difference, one after the other.

    The time by which S2 follows S1 stays, to be right where the signal moves faster: the lag takes
    over that of a delay or a low-pass, and the delay that of the lag, if they are there. If neither
    is left, it stays where it was measured with certainty: while S1 is right, no lag matters.

    Args:
        problem: What was fitted.
        sensors: What the sensors are like.
        parameters: The result.
    """
    is_sure = has_lag_to_fit(sensors)
    most = NO_WORSE * problem.misfit(parameters)
    for names, heir in (
        (("s1.spike_threshold",), ""),
        (("s1.drift_time_constant", "s1.drift_prior"), ""),
        (("s1.drift_prior",), ""),
        (("s2.delay", "s2.lag_time_constant"), ""),
        (("s2.delay",), "s2.lag_time_constant"),
        (("s2.lag_time_constant",), "s2.delay"),
        (("s1.lowpass_time_constant",), "s2.lag_time_constant"),
        (("aggregator.drift.large",), ""),
    ):
        values = {k: v for k, v in flatten(parameters).items() if isinstance(v, float)}
        changes = dict.fromkeys(names, 0.0)
        if values.get(heir, 0.0) > 0.0:
            changes[heir] = values[heir] + values[names[0]]
        elif is_sure and names[0] in LAGS:
            continue
        simpler = replace(parameters, allowed(Parameters, changes))
        if simpler != parameters and problem.misfit(simpler) <= most:
            parameters = simpler
    return parameters


def shorten_bias_time_constant(problem: Problem, parameters: Parameters) -> Parameters:
    """Halve the time constant of the bias as often as that costs next to nothing.

    A recording in which S1 hardly drifts favours slow learning, which could not follow a drift that
    comes later; often a much shorter time constant fits as well.

    Args:
        problem: What was fitted.
        parameters: The result.
    """
    most = SHORTENING_COSTS * problem.misfit(parameters)
    intervals = np.concatenate([np.diff(each.s2_ns) for each in problem.recordings])
    instant = INSTANT * float(np.median(intervals)) * 1e-9
    while parameters.s1.bias_time_constant > instant:
        half = 0.5 * parameters.s1.bias_time_constant
        quicker = replace(parameters, {"s1.bias_time_constant": half})
        if problem.misfit(quicker) > most:
            return parameters
        parameters = quicker
    return parameters


def with_safety_net(problem: Problem, parameters: Parameters) -> Parameters:
    """Set from which difference on S1 counts as wrong: far beyond any of the recording.

    The first innovations are large, because nothing was known before, and do not count; where the
    rule fires at them and increases the misfit, the difference is doubled.

    Args:
        problem: What was fitted.
        parameters: The result; it stays as it is unless the bias is learnt.
    """
    found = joined(parameters, problem.recordings).innovation
    known = np.abs(found[np.isfinite(found)])
    if known.size == 0 or not known.max() > 0.0:
        return parameters
    most = NO_WORSE * problem.misfit(parameters)
    for doublings in range(MOST_DOUBLINGS + 1):
        guarded = replace(parameters, safety_net(float(known.max()) * 2.0**doublings))
        if problem.misfit(guarded) <= most:
            return guarded
    return parameters


def with_deviation(problem: Problem, parameters: Parameters, optimism: float) -> Parameters:
    """Fit the standard deviation to the errors: what of S1's noise comes through, and its factor.

    Args:
        problem: What was fitted.
        parameters: The result.
        optimism: By how much larger errors are assumed to be on the next recording: halfway, as a
            ratio, between those fitted to and those on the worst unseen part.
    """
    plain = replace(parameters, {"estimate.deviation_scale": 1.0, "s1.noise": 0.0})
    traces = [run(fusion(plain, each.started_ns), each) for each in problem.recordings]
    deviation = np.concatenate([each.standard_deviation for each in traces])
    where = problem.counted & (deviation > 0.0)
    if not where.any():
        return parameters
    error = (np.concatenate([each.value for each in traces]) - problem.target)[where]
    typical = root_mean_square(error)
    best, least = plain, math.inf
    for share in _FLOORS:
        floor = share * typical
        variance = np.square(deviation[where]) + floor**2
        factor = float(np.mean(np.square(error) / variance))
        unlikely = math.log(max(factor, TINY)) + float(np.mean(np.log(variance)))
        if unlikely < least:
            ratios = np.quantile(np.abs(error) / np.sqrt(variance), WITHIN)
            scale = float(np.max(ratios / (1.0, 2.0))) * optimism
            changes = {"estimate.deviation_scale": scale, "s1.noise": floor}
            best, least = replace(parameters, allowed(Parameters, changes)), unlikely
    return best


def with_assumed_deviation(
    sensors: Characteristics, parameters: Parameters, factor: float
) -> Parameters:
    """Set what of S1's noise comes through its low-pass, and a factor for what S2 does not show.

    Args:
        sensors: What the sensors are like.
        parameters: The result.
        factor: The factor.
    """
    gain = lag_gain(sensors.s1_interval, parameters.s1.lowpass_time_constant)
    through = sensors.s1_noise * math.sqrt(gain / (2.0 - gain))
    changes = {"estimate.deviation_scale": factor, "s1.noise": through}
    return replace(parameters, allowed(Parameters, changes))


def rounded(problem: Problem, parameters: Parameters) -> Parameters:
    """Round fitted values to ``DIGITS`` significant digits.

    Args:
        problem: What was fitted.
        parameters: The result.
    """
    given = flatten(problem.base)
    return replace(
        parameters,
        {
            name: _rounded(value)
            for name, value in flatten(parameters).items()
            if isinstance(value, float) and value != given[name]
        },
    )


def with_predictor(problem: Problem, parameters: Parameters) -> Parameters:
    """Switch the predictor on if it helps in most of the blocks and overall.

    Args:
        problem: What was fitted.
        parameters: The result, as yet without predictor.
    """
    parts = model_selection.parts_of(problem)

    def part_errors(parameters: Parameters) -> Reals:
        errors = _values(problem, parameters) - problem.target
        return model_selection.errors_by_part(errors, parts)

    without = part_errors(parameters)
    best, least = parameters, BETTER_BY * root_mean_square(without)
    for tolerance in _TOLERANCES:
        gate = {"gate.tolerance": _rounded(tolerance * problem.misfit(parameters))}
        on = replace(parameters, {"predictor.enabled": True, **allowed(Parameters, gate)})
        errors = part_errors(on)
        whole = root_mean_square(errors)
        if whole < least and np.count_nonzero(errors < without) >= errors.size - 1:
            best, least = on, whole
    return best


def error_of(problem: Problem, parameters: Parameters) -> float:
    """Return the root mean square error of the whole estimator, including its predictor.

    Args:
        problem: What was fitted.
        parameters: Of the estimator.
    """
    value = _values(problem, parameters)
    return root_mean_square((value - problem.target)[problem.counted])


def errors_of(problem: Problem, parameters: Parameters) -> list[float]:
    """Return the same on each recording alone.

    Args:
        problem: What was fitted.
        parameters: Of the estimator.
    """
    return _errors_of(problem, _values(problem, parameters))


def method_errors(problem: Problem, method: Method) -> list[float]:
    """Return the root mean square error of a baseline on each recording alone.

    Args:
        problem: What was fitted.
        method: The baseline.
    """
    return _errors_of(
        problem, np.concatenate([values(method, each) for each in problem.recordings])
    )


def _errors_of(problem: Problem, values: Reals) -> list[float]:
    errors = np.where(problem.counted, values - problem.target, np.nan)
    return [root_mean_square(each[np.isfinite(each)]) for each in problem.by_recording(errors)]


def _values(problem: Problem, parameters: Parameters) -> Reals:
    """Run the whole estimator over every recording; return its estimates in a row, shape (n,)."""
    return np.concatenate(
        [values(fusion(parameters, each.started_ns), each) for each in problem.recordings]
    )


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
