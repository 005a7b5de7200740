# SPDX-License-Identifier: Apache-2.0
"""The estimator: condition, aggregate or observe, gate, predict; the paper's Figs 1 and 5.

``observe_s2`` takes every sample of S2, ``update`` every sample of S1 that is to give an
estimate. Both are pure: a state goes in, a new one comes out.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.aggregator import (
    Aggregate,
    SlowSensor,
    aggregate,
    no_slow_sensor,
    observe_slow,
    single,
)
from fuzzy_fusion_ros.core.conditioning import FastSensor, condition, no_fast_sensor
from fuzzy_fusion_ros.core.deviation import (
    OUTLIER,
    SHOCK,
    Evidence,
    deviation,
    no_evidence,
    weighed,
)
from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction, accepts, combine
from fuzzy_fusion_ros.core.numerics import bounded, seconds_between
from fuzzy_fusion_ros.core.observer import (
    LASTING,
    Belief,
    believe,
    believed,
    moved_on,
    no_belief,
    observes,
    s2_decides,
    variance_at,
)
from fuzzy_fusion_ros.core.predictor import Predictor, learn, prediction_at, untrained
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, S2_TIMEOUT, timeout_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

WAITING, FUSED, S1_ONLY, S2_ONLY = 0, 1, 2, 3
"""Modes of an estimate. WAITING: none yet, S2 has not spoken but is not overdue either."""

MODE_NAMES = {FUSED: "FUSED", S1_ONLY: "S1_ONLY", S2_ONLY: "S2_ONLY"}
"""The modes in which there is an estimate, by name."""


class Sensors(NamedTuple):
    """What is kept of the sensors.

    Attributes:
        s1: S1, conditioned.
        s2: S2, held, and its rate.
        belief: What the observer believes; nothing while it is off.
        evidence: How far S2 has lately been from what was expected of it.
    """

    s1: FastSensor
    s2: SlowSensor
    belief: Belief
    evidence: Evidence


class State(NamedTuple):
    """Everything the estimator keeps between samples.

    Attributes:
        sensors: What is kept of the sensors.
        predictor: History and rules of the predictor.
        started_ns: Stamp of the first S1 sample, 0 before it.
    """

    sensors: Sensors
    predictor: Predictor
    started_ns: int


class Estimate(NamedTuple):
    """One estimate and why it is what it is.

    Attributes:
        mode: FUSED, S1_ONLY or S2_ONLY; with WAITING there is no estimate.
        value: The final estimate, unit of the signal.
        aggregate: The aggregator's output with weight, drift and firing strengths.
        prediction: What the predictor had said for this step.
        accepted: Whether the gate let the prediction count.
        standard_deviation: Of the estimate's error, unit of the signal; 0 where nothing is known.
    """

    mode: int
    value: float
    aggregate: Aggregate
    prediction: Prediction
    accepted: bool
    standard_deviation: float = 0.0


def no_sensors() -> Sensors:
    """Return what is kept before any sample."""
    return Sensors(no_fast_sensor(), no_slow_sensor(), no_belief(), no_evidence())


def initial_state(parameters: Parameters) -> State:
    """Return the state before any sample."""
    return State(
        sensors=no_sensors(),
        predictor=untrained(parameters.predictor.samples, parameters.predictor.rules),
        started_ns=0,
    )


def observe_s2(parameters: Parameters, state: State, stamp_ns: int, value: float) -> State:
    """Take a sample of S2."""
    sensors = heard_s2(parameters, state.sensors, stamp_ns, value)
    return State(sensors, state.predictor, state.started_ns)


def update(
    parameters: Parameters, state: State, stamp_ns: int, value: float
) -> tuple[Estimate, State]:
    """Take a sample of S1 and estimate: Fig. 1 from left to right, its gate as in Fig. 5.

    Args:
        parameters: All parameters, or their ``numbers``.
        state: The state after the last sample.
        stamp_ns: Stamp of the sample, later than that of the last S1 sample.
        value: The sample, finite.

    Returns:
        The estimate, finite, and the state after it.
    """
    started_ns = state.started_ns if state.started_ns > 0 else stamp_ns
    mode = mode_at(parameters.s2.timeout, state.sensors.s2, started_ns, stamp_ns)
    fa, sensors = fused(parameters, state.sensors, mode, stamp_ns, value)
    prediction = prediction_at(parameters.predictor, state.predictor, stamp_ns)
    accepted = accepts(prediction, fa.value, parameters.gate.tolerance)
    final = combine(prediction, fa.value, accepted)
    learnt = state.predictor
    if mode != WAITING:
        learnt = learn(parameters.predictor, learnt, stamp_ns, final)

    sure = standard_deviation(parameters, sensors, stamp_ns)
    estimate = Estimate(mode, final, fa, prediction, accepted, sure)
    return estimate, State(sensors, learnt, started_ns)


def heard_s2(parameters: Parameters, kept: Sensors, stamp_ns: int, value: float) -> Sensors:
    """Hold a sample of S2, move its rate, and let the observer believe it.

    While S1 is silent the observer waits: what it would compare S2 with is out of date.
    """
    s2 = observe_slow(
        parameters.aggregator.rate_time_constant,
        parameters.s2.timeout,
        kept.s2,
        stamp_ns,
        value,
    )
    sensors = Sensors(kept.s1, s2, kept.belief, kept.evidence)
    longest = timeout_for(parameters.s1.timeout, S1_TIMEOUT, kept.s1.interval)
    is_fresh = seconds_between(kept.s1.stamp_ns, stamp_ns) <= longest
    if observes(parameters) and is_fresh and kept.belief.stamp_ns > 0:
        return confronted(parameters, sensors, seconds_between(s2.stamp_ns, kept.s1.stamp_ns))
    if not observes(parameters) and is_fresh and kept.s1.stamp_ns > 0:
        evidence = weighed(kept.evidence, 0.0, kept.s1.smooth.value - value, 1.0)
        return Sensors(kept.s1, s2, kept.belief, evidence)
    return sensors


def confronted(parameters: Parameters, kept: Sensors, late: float) -> Sensors:
    """Correct the observer by S2's newest sample, and update the scale of its standard deviation.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: What is kept of the sensors.
        late: How long after its stamp the sample came, seconds, on S1's stamps.
    """
    usual = kept.evidence.variance
    belief, s1 = believe(parameters, kept.belief, kept.s1, kept.s2, late, usual)
    most = OUTLIER if 0 < belief.outliers < LASTING else SHOCK
    evidence = weighed(kept.evidence, parameters.s2.noise, belief.innovation, belief.variance, most)
    return Sensors(s1, kept.s2, belief, evidence)


def fused(
    parameters: Parameters, kept: Sensors, mode: int, stamp_ns: int, value: float
) -> tuple[Aggregate, Sensors]:
    """Condition a sample of S1 and fuse it with S2: by the paper's blend, or by the observer.

    Args:
        parameters: All parameters, or their ``numbers``.
        kept: What is kept of the sensors.
        mode: What the sample gives; unless FUSED it is S1 alone.
        stamp_ns: Stamp of the sample.
        value: The sample, finite.
    """
    s2, evidence = kept.s2, kept.evidence
    decides = s2_decides(parameters, s2)
    s1 = condition(parameters.s1, kept.s1, s2.rate, decides, stamp_ns, value)
    if observes(parameters):
        belief = moved_on(parameters, kept.belief, kept.s1, s1, s2, evidence.variance)
        if kept.belief.stamp_ns == 0:  # it begins: evidence of the blend is on another scale
            evidence = no_evidence()
        sensors = Sensors(s1, s2, belief, evidence)
        if mode == FUSED and belief.s2_ns != s2.stamp_ns:
            sensors = confronted(parameters, sensors, 0.0)
        fa = believed(sensors.belief, sensors.s1)
        return fa if mode == FUSED else single(fa.value, 1.0), sensors
    belief = kept.belief
    if belief.stamp_ns > 0:  # the observer has been switched off
        belief, evidence = no_belief(), no_evidence()
    if mode != FUSED:
        return single(s1.smooth.value, 1.0), Sensors(s1, s2, belief, evidence)
    if evidence.samples == 0:  # S2 came before S1
        evidence = weighed(evidence, 0.0, s1.smooth.value - s2.value, 1.0)
    fa = aggregate(parameters.aggregator, s1.smooth.value, s2.value, s2.rate)
    return fa, Sensors(s1, s2, belief, evidence)


def standard_deviation(parameters: Parameters, sensors: Sensors, stamp_ns: int) -> float:
    """Return the standard deviation of an estimate at a sample of S1, unit of the signal.

    Args:
        parameters: All parameters, or their ``numbers``.
        sensors: What is kept of the sensors, with the sample.
        stamp_ns: Its stamp.
    """
    s2, evidence = sensors.s2, sensors.evidence
    if evidence.samples == 0:
        return 0.0
    if observes(parameters):
        variance = variance_at(parameters, sensors.belief, s2.interval, stamp_ns)
    else:
        age = seconds_between(s2.stamp_ns, stamp_ns)
        variance = max(1.0, age / s2.interval) if s2.interval > 0.0 else 1.0
    scale, floor = parameters.estimate.deviation_scale, parameters.s1.noise
    return deviation(scale, floor, evidence, variance)


def without_s1(parameters: Parameters, state: State, stamp_ns: int) -> Estimate:
    """Return S2 alone as the estimate, at a sample of S2 that has been observed: S1 is lost.

    Args:
        parameters: All parameters, or their ``numbers``.
        state: The state after the sample.
        stamp_ns: Its stamp, nanoseconds.
    """
    s2, evidence = state.sensors.s2, state.sensors.evidence
    late = abs(s2.rate) * (parameters.s2.lag_time_constant + parameters.s2.delay)
    sure = 0.0
    if evidence.samples > 0:
        sure = deviation(parameters.estimate.deviation_scale, bounded(late), evidence, 1.0)
    return Estimate(
        mode=S2_ONLY,
        value=s2.value,
        aggregate=single(s2.value, 0.0),
        prediction=NO_PREDICTION,
        accepted=False,
        standard_deviation=sure,
    )


def mode_at(timeout: float, s2: SlowSensor, started_ns: int, stamp_ns: int) -> int:
    """Return what an S1 sample at ``stamp_ns`` gives: S2 is awaited, there, or lost.

    Args:
        timeout: Of S2, seconds; 0 is automatic.
        s2: S2 as held.
        started_ns: Stamp of the first S1 sample, from which a first S2 sample is awaited.
        stamp_ns: Stamp of the S1 sample.
    """
    heard_ns = s2.stamp_ns if s2.samples > 0 else started_ns
    if seconds_between(heard_ns, stamp_ns) > timeout_for(timeout, S2_TIMEOUT, s2.interval):
        return S1_ONLY
    return FUSED if s2.samples > 0 else WAITING
