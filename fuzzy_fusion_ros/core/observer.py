# SPDX-License-Identifier: Apache-2.0
"""The observer: Table 1 on the innovation of S2, seen through S2's lag. Our extension.

The paper blends S1 with raw S2, which is late. Here the estimate ``x = S1 - c``, with S1
conditioned and ``c`` its bias, passes a model of S2: a first-order lag, then a delay. The output is
what S2 would show if the estimate were right; its difference from S2 is the innovation. A Kalman
filter corrects ``c`` by it, in which Table 1 sets how far the sample is trusted: S2's noise counts
as ``noise / (1 - W1)``. Without lag, and with ``c`` unknown, this is the paper's blend.

The model is linear, so S1 and ``c`` pass it separately: S1 with the true delay, at the stamp of the
sample however late that comes; ``c``, which changes slowly, with a second lag in place of the
delay. Variances are in units of S2's noise variance, since only their ratios matter.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.adaptation import (
    Adaptation,
    Confronted,
    adapted,
    adapts,
    no_adaptation,
    paused,
    switched,
    twins_on,
)
from fuzzy_fusion_ros.core.aggregator import (
    Aggregate,
    FiringStrengths,
    SlowSensor,
    defuzzify,
    firing_strengths,
)
from fuzzy_fusion_ros.core.conditioning import FastSensor, stepped_to
from fuzzy_fusion_ros.core.covariance import (
    Covariance,
    Gain,
    corrected,
    gain,
    of_bias,
    propagated,
    raised,
)
from fuzzy_fusion_ros.core.delay_line import empty_line, extended, shifted
from fuzzy_fusion_ros.core.model import (
    Lagged,
    Shown,
    States,
    carried,
    corrected_states,
    lag_gains,
    no_states,
    shown_at,
    shown_on,
)
from fuzzy_fusion_ros.core.numerics import bounded, clamped, seconds_between
from fuzzy_fusion_ros.parameters.fusion import (
    AggregatorParameters,
    Parameters,
    SlowSensorParameters,
)

UNKNOWN = 1e4
"""Standard deviation of a bias of which nothing is known, in those of S2's noise; no deviation
grows by more at a time."""

STEEPEST = 1e15
"""No standard deviation of a slope grows by more at a time, in those of S2's noise per second: its
square stays finite, and times may be in microseconds."""

LOST = 100.0
"""Standard deviation of where S2 leads after a gap, at most, in those of S2's noise: the next
sample of S2 then sets the estimate, and a variance that is not much larger keeps its digits."""

LEAST_BELIEF = 1e-6
"""A sample of S2 is trusted at least this much, whatever W1."""

LASTING = 5
"""This many consecutive outliers of S2 that agree are a step: the signal or S2 itself has moved."""

LONGEST = 100
"""Where S2's noise is not known, at most this many consecutive outliers of S2 are held back: after
that, the innovations before them were too small, as at rest, to define an outlier."""

EVIDENCE = 9.0
"""Rejected samples of S1 explain S2 if they lower the squared innovation by this many variances."""


class Belief(NamedTuple):
    """What is believed of the signal, by what S2 has said.

    Attributes:
        samples: S2 samples believed since the last start.
        s2_ns: Stamp of the newest of them.
        late: Longest time after its stamp that a sample of S2 came, seconds, on S1's stamps.
        stamp_ns: Stamp that ``covariance`` is for; 0 before the first S1 sample.
        states: S1's bias and its slope, and what S2 would show.
        doubted: S1 as S2 would show it if the samples that are being rejected were right.
        covariance: Of bias, slope and lags, in units of S2's noise variance.
        innovation: Of the newest sample of S2, unit of the signal: believed minus measured.
        variance: Expected square of that, in units of S2's noise variance.
        weight: W1 of that sample, 0 to 1: the share of the innovation that is not believed.
        drift: How much more than the innovation the signal is off by now, unit of the signal.
        strengths: Firing strengths at that sample.
        outliers: How many consecutive outliers of S2 agree, up to ``LASTING``; 0 if the newest
            sample is none.
        held_back: How many consecutive samples of S2 are outliers, up to ``LONGEST``.
        adaptation: Factors of S2's lag and of S1's movements.
    """

    samples: int
    s2_ns: int
    late: float
    stamp_ns: int
    states: States
    doubted: Shown
    covariance: Covariance
    innovation: float
    variance: float
    weight: float
    drift: float
    strengths: FiringStrengths
    outliers: int
    held_back: int
    adaptation: Adaptation


def no_belief() -> Belief:
    """Return the state before any sample."""
    return Belief(
        samples=0,
        s2_ns=0,
        late=0.0,
        stamp_ns=0,
        states=no_states(),
        doubted=Shown(0.0, empty_line()),
        covariance=of_bias(0.0, 0.0, 0.0),
        innovation=0.0,
        variance=1.0,
        weight=1.0,
        drift=0.0,
        strengths=FiringStrengths(0.0, 0.0, 0.0, 0.0),
        outliers=0,
        held_back=0,
        adaptation=no_adaptation(),
    )


def observes(parameters: Parameters) -> bool:
    """Return whether S1's bias is learnt: the observer then takes the place of the blend."""
    return bool(parameters.s1.bias_time_constant > 0.0)


def s2_decides(parameters: Parameters, s2: SlowSensor) -> bool:
    """Return whether it is for S2 to say if S1 has stepped: it has shown how it moves."""
    return observes(parameters) and s2.samples > 1


def moved_on(
    parameters: Parameters,
    kept: Belief,
    before: FastSensor,
    s1: FastSensor,
    s2: SlowSensor,
    usual: float,
) -> Belief:
    """Move the belief on to a sample of S1, and it through S2's model.

    ``c += b dt``, and both through ``l += (1 - exp(-dt / lag)) (s1 - l)``. The first sample, also
    the first after a gap, starts S2's model from there.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: The belief so far.
        before: S1 before the sample.
        s1: S1 with it, conditioned.
        s2: S2 as held.
        usual: As for :func:`believe`.
    """
    if kept.stamp_ns == 0 or s1.samples == 1:
        return started(parameters, kept, before, s1, s2, usual)
    dt = seconds_between(before.stamp_ns, s1.stamp_ns)
    step = s1.smooth.step
    states, adaptation = kept.states, kept.adaptation
    if step != 0.0:  # S1 has stepped, and has been off by that for as long as matters
        states = stepped(states, step, adaptation.scale.value)
        adaptation = paused(adaptation)
    reach = adaptation.lag.value * parameters.s2.delay + kept.late
    if adapts(parameters.adapt, adaptation):
        adaptation = switched(parameters.adapt, adaptation, states, before.smooth.value)
        adaptation = twins_on(parameters.s2, adaptation, dt, s1.stamp_ns, s1.smooth.value, reach)
    first, second = lag_gains(parameters.s2, adaptation.lag.value, dt)
    shown = shown_on(states.shown, first, s1.stamp_ns, s1.smooth.value, reach)
    doubted = kept.doubted
    if s1.smooth.rejected > 0.0:
        begun = kept.states.shown if before.smooth.rejected <= 0.0 else kept.doubted
        doubted = shown_on(begun, first, s1.stamp_ns, s1.smooth.newest, reach)
    return Belief(
        samples=kept.samples,
        s2_ns=kept.s2_ns,
        late=kept.late,
        stamp_ns=kept.stamp_ns,
        states=carried(states, shown, dt, first, second),
        doubted=doubted,
        covariance=kept.covariance,
        innovation=kept.innovation,
        variance=kept.variance,
        weight=kept.weight,
        drift=kept.drift,
        strengths=kept.strengths,
        outliers=kept.outliers,
        held_back=kept.held_back,
        adaptation=adaptation,
    )


def stepped(states: States, step: float, scale: float) -> States:
    """Return the states after S1 has stepped, and been off by that for as long as matters.

    Args:
        states: As they were.
        step: How far S1 has stepped.
        scale: What its movements are multiplied by.
    """
    shown = Shown(bounded(states.shown.lagged + step), shifted(states.shown.line, step))
    off = scale * step
    through = Lagged(bounded(states.through.first + off), bounded(states.through.second + off))
    return States(bounded(states.bias + off), states.slope, through, shown)


def started(
    parameters: Parameters,
    kept: Belief,
    before: FastSensor,
    s1: FastSensor,
    s2: SlowSensor,
    usual: float,
) -> Belief:
    """Return the belief at the first sample of S1, or the first after a gap.

    S2's model starts from there; the bias and its slope are kept, and are less certain by what
    they may have walked. The integral of a rate has no value of its own after a gap: it may be off
    by how far the signal has moved since what S2 shows. If S2 has spoken in the gap, the estimate
    begins there, on the line on which S2 moves.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: The belief so far: the bias as of ``before``, its covariance as of its stamp.
        before: S1 before the sample.
        s1: S1 with it.
        s2: S2 as held.
        usual: As for :func:`believe`.
    """
    states, covariance, adaptation = kept.states, kept.covariance, paused(kept.adaptation)
    factor, scale, value = adaptation.lag.value, adaptation.scale.value, s1.smooth.value
    lag, delay = factor * parameters.s2.lag_time_constant, factor * parameters.s2.delay
    bias, slope, s2_ns = 0.0, 0.0, kept.s2_ns
    if kept.stamp_ns == 0:
        covariance = prior(parameters)
    else:
        since = seconds_between(before.stamp_ns, s1.stamp_ns)
        bias = bounded(states.bias + states.slope * since)
        dt = max(seconds_between(kept.stamp_ns, s1.stamp_ns), 0.0)
        covariance = walked(parameters, covariance, factor, s2.interval, dt)
        if parameters.s1.is_rate:
            behind = max(seconds_between(s2.stamp_ns, s1.stamp_ns), 0.0) + lag + delay
            moved = bounded(s2.rate * behind)
            doubted = doubt_in(moved, usual, parameters.s2.noise)
            covariance = raised(covariance, doubted)
            if s2.stamp_ns != s2_ns:
                covariance = of_bias(1.0 + doubted, 0.0, covariance.bb)
                bias = bounded(scale * value - s2.value - moved)
                slope, s2_ns = s2.rate / scale, s2.stamp_ns
    lagged, line, reach = bounded(value - slope * lag), empty_line(), delay + kept.late
    if slope != 0.0:
        line = extended(line, s1.stamp_ns - int(reach * 1e9), lagged - slope * reach, delay)
    shown = Shown(lagged, extended(line, s1.stamp_ns, lagged, delay))
    return Belief(
        samples=kept.samples,
        s2_ns=s2_ns,
        late=kept.late,
        stamp_ns=max(kept.stamp_ns, s1.stamp_ns),
        states=States(bias, states.slope, Lagged(bias, bias), shown),
        doubted=shown,
        covariance=of_bias(covariance.cc, covariance.cb, covariance.bb),
        innovation=kept.innovation,
        variance=kept.variance,
        weight=kept.weight,
        drift=kept.drift,
        strengths=kept.strengths,
        outliers=kept.outliers,
        held_back=kept.held_back,
        adaptation=adaptation,
    )


def doubt_in(moved: float, usual: float, noise: float) -> float:
    """Return the variance of where S2 leads, in squares of S2's noise.

    Args:
        moved: How far that is from what S2 has shown, unit of the signal.
        usual: As for :func:`believe`.
        noise: Of S2, unit of the signal; counts where nothing is usual yet.
    """
    scatter = usual if usual > 0.0 else noise * noise
    if scatter <= 0.0:
        return LOST * LOST
    return min(moved * moved / scatter, LOST * LOST)


def believe(
    parameters: Parameters,
    kept: Belief,
    s1: FastSensor,
    s2: SlowSensor,
    late: float,
    usual: float,
) -> tuple[Belief, FastSensor]:
    """Correct the belief by a sample of S2; rejected samples of S1 may turn out to be right.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: The belief, moved on to S1's newest sample.
        s1: S1, conditioned.
        s2: S2, holding the sample.
        late: How long after its stamp it came, seconds, on S1's stamps.
        usual: Mean square of recent innovations, each over its expected variance, unit of the
            signal squared; 0 where none is known.

    Returns:
        The belief after it, and S1, moved to the rejected samples if these explain S2.
    """
    dt = max(seconds_between(kept.stamp_ns, s2.stamp_ns), 0.0)
    adaptation = kept.adaptation
    factor, scale = adaptation.lag.value, adaptation.scale.value
    p = walked(parameters, kept.covariance, factor, s2.interval, dt)
    shown, expected = kept.states.shown, kept.states.through.second + s2.value
    seen = shown_at(parameters.s2, factor, shown, s1.stamp_ns, s2.stamp_ns)
    innovation = bounded(scale * seen - expected)
    strengths = rule_strengths(parameters.aggregator, innovation, s2)
    noise = noise_variance(parameters.aggregator, strengths)
    if s1.smooth.rejected > 0.0 and s2.samples > 1:
        margin = EVIDENCE * (p.m22 + noise) * parameters.s2.noise * parameters.s2.noise
        at = shown_at(parameters.s2, factor, kept.doubted, s1.stamp_ns, s2.stamp_ns)
        doubted = scale * at - expected
        if is_explained(doubted, innovation, margin):
            shown, innovation, adaptation = kept.doubted, bounded(doubted), paused(adaptation)
            s1 = FastSensor(s1.samples, s1.stamp_ns, s1.interval, stepped_to(s1.smooth.newest, 0.0))
            strengths = rule_strengths(parameters.aggregator, innovation, s2)
            noise = noise_variance(parameters.aggregator, strengths)
    limit = outlier_limit(parameters.s2, usual, p.m22 + noise)
    outliers, counted = outliers_with(kept, innovation, limit, parameters.s2.noise), innovation
    if 0 < outliers < LASTING:
        counted = clamped(innovation, -limit, limit)
        strengths = rule_strengths(parameters.aggregator, counted, s2)
        noise = noise_variance(parameters.aggregator, strengths)
        noise += (p.m22 + noise) * (abs(innovation) / limit - 1.0)
        usual = 0.0
    p = raised(p, doubt(parameters, strengths, counted))
    k = gain(p, noise)
    states = corrected_states(kept.states, shown, k, innovation)
    if adaptation.lag.is_on or adaptation.scale.is_on:
        variance = usual * (p.m22 + noise)
        sample = Confronted(
            s1.stamp_ns, s2.stamp_ns, s2.value, seen, innovation, variance, s2.interval
        )
        adaptation, states = adapted(parameters.adapt, parameters.s2, adaptation, states, k, sample)
    return (
        Belief(
            samples=kept.samples + 1,
            s2_ns=s2.stamp_ns,
            late=max(kept.late, late),
            stamp_ns=max(kept.stamp_ns, s2.stamp_ns),
            states=states,
            doubted=kept.doubted,
            covariance=corrected(p, k, noise),
            innovation=innovation,
            variance=p.m22 + noise,
            weight=clamped(1.0 - k.second, 0.0, 1.0),
            drift=lead(k) * abs(innovation),
            strengths=strengths,
            outliers=outliers,
            held_back=min(kept.held_back + 1, LONGEST) if outliers > 0 else 0,
            adaptation=adaptation,
        ),
        s1,
    )


def outlier_limit(parameters: SlowSensorParameters, usual: float, variance: float) -> float:
    """Return how far an innovation of S2 may be from 0; 0 if it may be any distance.

    Args:
        parameters: Of S2.
        usual: As for :func:`believe`; S2's noise, where it is known, counts if it is larger.
        variance: Expected square of the innovation, in units of S2's noise variance.
    """
    if parameters.outlier_threshold <= 0.0 or usual <= 0.0:
        return 0.0
    scatter = max(usual, parameters.noise * parameters.noise)
    return parameters.outlier_threshold * math.sqrt(scatter * variance)


def outliers_with(kept: Belief, innovation: float, limit: float, noise: float) -> int:
    """Return how many consecutive outliers of S2 agree, with its newest sample; 0 if it is none.

    The first of them agree within the limit. From ``LASTING`` on they are a step of S2, which
    passes as long as what is left of it does not grow by more.

    Args:
        kept: The belief before the sample.
        innovation: Its innovation.
        limit: As from :func:`outlier_limit`.
        noise: Of S2, unit of the signal; 0 where it is not known.
    """
    if not abs(innovation) > limit > 0.0:
        return 0
    if kept.held_back >= LONGEST and noise <= 0.0:
        return LASTING
    if kept.outliers >= LASTING:
        agrees = innovation * kept.innovation > 0.0
        agrees = agrees and abs(innovation) <= abs(kept.innovation) + limit
    else:
        agrees = abs(innovation - kept.innovation) <= limit
    return min(kept.outliers + 1, LASTING) if agrees and kept.outliers > 0 else 1


def believed(kept: Belief, s1: FastSensor) -> Aggregate:
    """Return what is believed of the signal, and what the newest S2 sample had to say in it."""
    value = bounded(kept.adaptation.scale.value * s1.smooth.value - kept.states.bias)
    return Aggregate(value, kept.weight, kept.drift, kept.strengths)


def variance_at(parameters: Parameters, kept: Belief, interval: float, stamp_ns: int) -> float:
    """Return the variance of what is believed at a stamp, in units of S2's noise variance.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: The belief.
        interval: Usual time between samples of S2, seconds.
        stamp_ns: The stamp, not before the belief's.
    """
    dt = max(seconds_between(kept.stamp_ns, stamp_ns), 0.0)
    return walked(parameters, kept.covariance, kept.adaptation.lag.value, interval, dt).cc


def prior(parameters: Parameters) -> Covariance:
    """Return the covariance before S2 has spoken: both priors over S2's noise, squared.

    Where ``bias_prior`` or S2's noise is 0, nothing is known of the bias and the first sample of S2
    sets it. The slope starts from 0, and stays there unless it is learnt.
    """
    s1, noise = parameters.s1, parameters.s2.noise
    ratio, turn = UNKNOWN, 0.0
    if noise > 0.0:
        ratio = min(s1.bias_prior / noise, UNKNOWN) if s1.bias_prior > 0.0 else UNKNOWN
        turn = min(s1.drift_prior / noise, STEEPEST) if s1.drift_time_constant > 0.0 else 0.0
    return of_bias(ratio * ratio, 0.0, turn * turn)


def walked(
    parameters: Parameters, p: Covariance, factor: float, interval: float, dt: float
) -> Covariance:
    """Return the covariance after a time in which the bias and its slope have walked.

    The bias walks by ``q^2 dt = noise^2 interval dt / T^2``, with ``interval`` that of S2. Where
    S2 is wholly believed and has no lag, the steady gain of the filter is then ``interval / T``
    for ``T`` much longer than it: the bias is learnt with ``T = s1.bias_time_constant``. Its
    slope walks by ``(q / T_d)^2 dt``, learnt with ``T_d = s1.drift_time_constant`` in the same way.

    Args:
        parameters: All parameters, or their ``numbers``.
        p: The covariance before.
        factor: Of S2's lag and delay.
        interval: Usual time between samples of S2, seconds; 0 while it is not known.
        dt: Seconds, 0 or more.
    """
    if dt <= 0.0:
        return p
    learning, drifting = parameters.s1.bias_time_constant, parameters.s1.drift_time_constant
    walk = min(interval * dt / learning / learning, UNKNOWN * UNKNOWN)
    turn = min(walk / drifting / drifting, STEEPEST * STEEPEST) if drifting > 0.0 else 0.0
    first, second = lag_gains(parameters.s2, factor, dt)
    p = propagated(
        Covariance(p.cc + walk, p.cb, p.c1, p.c2, p.bb, p.b1, p.b2, p.m11, p.m12, p.m22),
        dt,
        first,
        second,
    )
    return Covariance(
        p.cc + turn * dt * dt / 3.0,
        p.cb + turn * dt / 2.0,
        p.c1,
        p.c2,
        p.bb + turn,
        p.b1,
        p.b2,
        p.m11,
        p.m12,
        p.m22,
    )


def rule_strengths(
    parameters: AggregatorParameters, innovation: float, s2: SlowSensor
) -> FiringStrengths:
    """Table 1's left side, on the innovation of S2 and on its rate."""
    return firing_strengths(abs(innovation), abs(s2.rate), parameters.difference, parameters.rate)


def noise_variance(parameters: AggregatorParameters, strengths: FiringStrengths) -> float:
    """Return the variance that a sample of S2 counts with: ``1 / (1 - W1)^2``, Table 1's W1."""
    levels = parameters.weight
    w1 = defuzzify(strengths, levels.small, levels.large, levels.very_small, levels.very_large)
    belief = max(1.0 - w1, LEAST_BELIEF)
    return 1.0 / (belief * belief)


def doubt(parameters: Parameters, strengths: FiringStrengths, innovation: float) -> float:
    """Return by how much the variance of the bias grows under *difference large, rate small*.

    That rule says that S1 has gone wrong, by no less than the innovation. Where S2's noise is not
    known there is nothing to compare it with.
    """
    if parameters.s2.noise <= 0.0:
        return 0.0
    ratio = min(abs(innovation) / parameters.s2.noise, UNKNOWN)
    return strengths.large_small * ratio * ratio


def is_explained(doubted: float, believed: float, margin: float) -> bool:
    """Return whether rejected samples of S1 explain a sample of S2 where the belief does not.

    Args:
        doubted: Innovation if the rejected samples are right.
        believed: Innovation if they are spikes.
        margin: Square of the signal's unit by which the first has to be smaller, squared.
    """
    doubted, believed = bounded(doubted), bounded(believed)
    return believed * believed - doubted * doubted > margin and abs(doubted) < 0.5 * abs(believed)


def lead(k: Gain) -> float:
    """Return how much more than an innovation the signal is off by, as a share of it.

    An innovation seen through a lag stands for a larger error now: the paper's drift, in the
    direction of motion. It vanishes with the lag.
    """
    return max(k.bias - k.second, 0.0)
