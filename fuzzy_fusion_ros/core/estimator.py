"""The estimator: condition, aggregate, gate, predict; the paper's Figs 1 and 5.

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
from fuzzy_fusion_ros.core.conditioning import Conditioned, condition, unconditioned
from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction, accepts, combine
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.predictor import Predictor, learn, prediction_at, untrained
from fuzzy_fusion_ros.core.silence import S2_TIMEOUT, timeout_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

WAITING, FUSED, S1_ONLY, S2_ONLY = 0, 1, 2, 3
"""Modes of an estimate. WAITING: none yet, S2 has not spoken but is not overdue either."""

MODE_NAMES = {FUSED: "FUSED", S1_ONLY: "S1_ONLY", S2_ONLY: "S2_ONLY"}
"""The modes in which there is an estimate, by name."""


class State(NamedTuple):
    """Everything the estimator keeps between samples.

    Attributes:
        s1: The conditioned S1.
        s2: S2, held, and its rate.
        predictor: History and rules of the predictor.
        started_ns: Stamp of the first S1 sample, 0 before it.
    """

    s1: Conditioned
    s2: SlowSensor
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
    """

    mode: int
    value: float
    aggregate: Aggregate
    prediction: Prediction
    accepted: bool


def initial_state(parameters: Parameters) -> State:
    """Return the state before any sample."""
    return State(
        s1=unconditioned(),
        s2=no_slow_sensor(),
        predictor=untrained(parameters.predictor.samples, parameters.predictor.rules),
        started_ns=0,
    )


def observe_s2(parameters: Parameters, state: State, stamp_ns: int, value: float) -> State:
    """Take a sample of S2: hold it and move its rate."""
    s2 = observe_slow(
        parameters.aggregator.rate_time_constant,
        parameters.s2.timeout,
        state.s2,
        stamp_ns,
        value,
    )
    return State(state.s1, s2, state.predictor, state.started_ns)


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
    mode = mode_at(parameters.s2.timeout, state.s2, started_ns, stamp_ns)

    s1 = condition(
        parameters.s1,
        parameters.s2,
        parameters.aggregator.rate,
        state.s1,
        state.s2,
        stamp_ns,
        value,
    )
    if mode == FUSED:
        fa = aggregate(parameters.aggregator, s1.value, state.s2.value, state.s2.rate)
    else:
        fa = single(s1.value, 1.0)
    prediction = prediction_at(parameters.predictor, state.predictor, stamp_ns)
    accepted = accepts(prediction, fa.value, parameters.gate.tolerance)
    final = combine(prediction, fa.value, accepted)
    learnt = state.predictor
    if mode != WAITING:
        learnt = learn(parameters.predictor, learnt, stamp_ns, final)

    estimate = Estimate(mode, final, fa, prediction, accepted)
    return estimate, State(s1, state.s2, learnt, started_ns)


def without_s1(parameters: Parameters, state: State, stamp_ns: int) -> Estimate:
    """Return S2 alone as the estimate, at a sample of S2 that has been observed: S1 is lost.

    Args:
        parameters: All parameters; none of them matters here.
        state: The state after the sample.
        stamp_ns: Its stamp, nanoseconds.
    """
    return Estimate(
        mode=S2_ONLY,
        value=state.s2.value,
        aggregate=single(state.s2.value, 0.0),
        prediction=NO_PREDICTION,
        accepted=False,
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
