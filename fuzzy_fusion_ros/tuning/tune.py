# SPDX-License-Identifier: Apache-2.0
"""Tuning: characterise the sensors, choose a target, cross-validate candidates, fit baselines."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.batch.series import Series, fusion, run
from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import allowed, flatten, replace
from fuzzy_fusion_ros.self_tuning.homes import safety_net
from fuzzy_fusion_ros.tuning import baselines, model_selection
from fuzzy_fusion_ros.tuning.characterise import (
    FEWEST_S1,
    TINY,
    Characteristics,
    characterise,
)
from fuzzy_fusion_ros.tuning.errors import TuneError
from fuzzy_fusion_ros.tuning.fit import SETTLING, Problem
from fuzzy_fusion_ros.tuning.kernel import outputs
from fuzzy_fusion_ros.tuning.model_selection import FittedCandidate
from fuzzy_fusion_ros.tuning.reference import reference_without_truth
from fuzzy_fusion_ros.tuning.search import Pool, Progress

NO_WORSE = 1.002
"""A step of the method is switched off if that increases the misfit by no more than this."""

INSTANT = 0.1
"""Below this share of S2's interval, learning is as good as instant."""

SHORTENING_COSTS = 1.02
"""The bias's time constant is shortened while that increases the misfit by no more than this."""

UNSEEN = 1.5
"""Without a truth, errors are larger by this than what S2's innovations show."""

DIGITS = 4
"""Significant digits of fitted values."""

S1_PATIENCE = 10.0
"""S1 counts as lost after this many of its intervals, or later if so given."""

BETTER_BY = 0.97
"""The predictor is switched on if it lowers the error to this share."""

_LOW_PASSES = (0.3, 100.0, 20)
"""Shortest, longest and number of time constants to try, in intervals of S1."""

_FLOORS = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
"""What of S1's noise may come through, in multiples of the error."""

_TOLERANCES = (0.3, 1.0, 3.0)
"""Tolerances of the gate to try, in multiples of the error without predictor."""


class Tuned(NamedTuple):
    """Result of tuning; errors are root mean squares in the signal's unit.

    Attributes:
        sensors: What the sensors are like.
        with_truth: Whether the target is a truth.
        target: What the fits are to, at each S1 sample, shape (n,), NaN where unknown.
        counted: Where the target counts, shape (n,).
        candidates: The candidates as fitted, in order of preference.
        chosen: Name of the one that was chosen.
        before: The parameters before.
        before_error: Their error.
        parameters: The parameters after.
        error: Their error.
        baselines: Parameters of the baselines, fitted by the same optimiser.
        baseline_errors: Error of each baseline by its name.
    """

    sensors: Characteristics
    with_truth: bool
    target: Reals
    counted: Flags
    candidates: tuple[FittedCandidate, ...]
    chosen: str
    before: Parameters
    before_error: float
    parameters: Parameters
    error: float
    baselines: BaselineParameters
    baseline_errors: dict[str, float]


def tune(
    series: Series,
    truth: Reals | None = None,
    parameters: Parameters | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: Progress = lambda done, of: None,
) -> Tuned:
    """Fit the fusion and the baselines to a recording.

    The same arguments give the same result, whatever the number of threads.

    Args:
        series: The recording.
        truth: At each S1 sample, shape (n,), NaN where unknown; without it a reference is made.
        parameters: Values of what a fit does not move; the defaults unless given.
        seed: Seed of the optimiser.
        threads: How many searches run at a time; one for each processor unless given.
        progress: Called after every evaluation.

    Raises:
        TuneError: There is too little to fit to.
    """
    series = series.at_s1()
    before = parameters or Parameters()
    sensors = characterise(series)
    known = series.s2_known > 0
    target = reference_without_truth(series, sensors) if truth is None else truth
    counted = known & np.isfinite(target)
    if np.count_nonzero(counted) < FEWEST_S1:
        raise TuneError(
            f"got {np.count_nonzero(counted)} samples of S1 within the span of the truth, expected "
            f"at least {FEWEST_S1}: check that their stamps overlap"
        )
    base = replace(before, {"self_tuning": False})
    if before.s1.timeout > 0.0:  # else it is automatic
        patience = {"s1.timeout": max(before.s1.timeout, S1_PATIENCE * sensors.s1_interval)}
        base = replace(base, allowed(Parameters, patience))
    with_truth = truth is not None
    problem = Problem(series, target, counted, base, with_truth)
    outputs(base, series)  # compiles it in this thread, so that the pool's threads do not wait
    baselines.warm_up(series)
    planned = model_selection.planned(sensors, with_truth) + baselines.planned()
    with Pool(threads, progress, planned) as pool:
        candidates = model_selection.cross_validate(problem, sensors, pool, seed)
        fitted = baselines.fit_baselines_in(pool, series, target, counted, seed)
    best = model_selection.chosen(candidates, int(series.s2_known[-1]), with_truth, sensors.related)
    final = best.parameters
    if with_truth:
        final = shorten_bias_time_constant(problem, simplified(problem, final))
    elif sensors.related:
        final = with_low_pass(problem, sensors, final)
    final = with_safety_net(problem, final)
    after = with_predictor(problem, rounded(problem, final))
    if with_truth:
        optimism = max(1.0, best.unseen / max(best.fitted, TINY))
        after = rounded(problem, with_deviation(problem, after, optimism))
    else:
        after = rounded(problem, with_assumed_deviation(sensors, after))
    return Tuned(
        sensors=sensors,
        with_truth=with_truth,
        target=target,
        counted=counted,
        candidates=tuple(candidates),
        chosen=best.name,
        before=before,
        before_error=error_of(problem, before),
        parameters=after,
        error=error_of(problem, after),
        baselines=fitted.parameters,
        baseline_errors=dict(fitted.errors),
    )


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


def simplified(problem: Problem, parameters: Parameters) -> Parameters:
    """Switch off every step of the method that makes no difference, one after the other.

    Args:
        problem: What was fitted.
        parameters: The result.
    """
    most = NO_WORSE * problem.misfit(parameters)
    for changes in (
        {"s1.spike_threshold": 0.0},
        {"s1.lowpass_time_constant": 0.0},
        {"s1.drift_time_constant": 0.0},
        {"s2.delay": 0.0},
        {"s2.lag_time_constant": 0.0},
        {"aggregator.drift.large": 0.0},
    ):
        simpler = replace(parameters, changes)
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
    instant = INSTANT * float(np.median(np.diff(problem.series.s2_ns))) * 1e-9
    while parameters.s1.bias_time_constant > instant:
        half = 0.5 * parameters.s1.bias_time_constant
        quicker = replace(parameters, {"s1.bias_time_constant": half})
        if problem.misfit(quicker) > most:
            return parameters
        parameters = quicker
    return parameters


def with_safety_net(problem: Problem, parameters: Parameters) -> Parameters:
    """Set from which difference on S1 counts as wrong: far beyond any of the recording.

    Args:
        problem: What was fitted.
        parameters: The result; it stays as it is unless the bias is learnt.
    """
    found = outputs(parameters, problem.series).innovation
    known = np.abs(found[np.isfinite(found)][SETTLING:])
    if known.size == 0 or not known.max() > 0.0:
        return parameters
    return replace(parameters, safety_net(float(known.max())))


def with_deviation(problem: Problem, parameters: Parameters, optimism: float) -> Parameters:
    """Fit the standard deviation to the errors: what of S1's noise comes through, and its factor.

    Args:
        problem: What was fitted.
        parameters: The result.
        optimism: By how much errors on unseen blocks are larger than those fitted to.
    """
    plain = replace(parameters, {"estimate.deviation_scale": 1.0, "s1.noise": 0.0})
    trace = run(fusion(plain, problem.series.started_ns), problem.series)
    where = problem.counted & (trace.standard_deviation > 0.0)
    if not where.any():
        return parameters
    error = (trace.value - problem.target)[where]
    typical = root_mean_square(error)
    best, least = plain, math.inf
    for share in _FLOORS:
        floor = share * typical
        variance = np.square(trace.standard_deviation[where]) + floor**2
        factor = float(np.mean(np.square(error) / variance))
        unlikely = math.log(max(factor, TINY)) + float(np.mean(np.log(variance)))
        if unlikely < least:
            scale = math.sqrt(factor) * optimism
            changes = {"estimate.deviation_scale": scale, "s1.noise": floor}
            best, least = replace(parameters, allowed(Parameters, changes)), unlikely
    return best


def with_assumed_deviation(sensors: Characteristics, parameters: Parameters) -> Parameters:
    """Set what of S1's noise comes through its low-pass, and a factor for what S2 does not show.

    Args:
        sensors: What the sensors are like.
        parameters: The result.
    """
    gain = lag_gain(sensors.s1_interval, parameters.s1.lowpass_time_constant)
    through = sensors.s1_noise * math.sqrt(gain / (2.0 - gain))
    changes = {"estimate.deviation_scale": UNSEEN, "s1.noise": through}
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
    """Switch the predictor on if it helps in most of the blocks and overall, otherwise off.

    Args:
        problem: What was fitted.
        parameters: The result, as yet without predictor.
    """
    blocks = model_selection.blocks_of(problem.counted)
    off = replace(parameters, {"predictor.enabled": False})
    without = _block_errors(problem, off, blocks)
    best, least = off, BETTER_BY * math.sqrt(np.mean(np.square(without)))
    for tolerance in _TOLERANCES:
        gate = {"gate.tolerance": _rounded(tolerance * problem.misfit(off))}
        on = replace(off, {"predictor.enabled": True, **allowed(Parameters, gate)})
        errors = _block_errors(problem, on, blocks)
        whole = math.sqrt(np.mean(np.square(errors)))
        helped = sum(a < b for a, b in zip(errors, without, strict=True))
        if whole < least and helped >= len(blocks) - 1:
            best, least = on, whole
    return best


def error_of(problem: Problem, parameters: Parameters) -> float:
    """Return the root mean square error of the whole estimator, including its predictor.

    Args:
        problem: What was fitted.
        parameters: Of the estimator.
    """
    return _block_errors(problem, parameters, [problem.counted])[0]


def _block_errors(problem: Problem, parameters: Parameters, blocks: list[Flags]) -> list[float]:
    method = fusion(parameters, problem.series.started_ns)
    value = run(method, problem.series).value
    return [root_mean_square((value - problem.target)[block]) for block in blocks]


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
