"""A whole recording at once: the estimator's steps over arrays, compiled where possible."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps, seconds_since
from fuzzy_fusion_ros.batch.compiled import compiled
from fuzzy_fusion_ros.core.estimator import WAITING, Estimate, initial_state, observe_s2, update
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers

State = Any
"""State of a method; each method has its own type."""


class Series(NamedTuple):
    """Samples of both sensors, each with its own stamps, and what was known when.

    Attributes:
        s1_ns: Stamps of S1, rising, shape (n,), nanoseconds.
        s1: Samples of S1, finite, shape (n,).
        s2_ns: Stamps of S2, rising, shape (m,), nanoseconds.
        s2: Samples of S2, finite, shape (m,).
        s2_known: How many samples of S2 had come before each of S1, not falling, shape (n,).
    """

    s1_ns: Stamps
    s1: Reals
    s2_ns: Stamps
    s2: Reals
    s2_known: Stamps


def seconds(series: Series) -> tuple[Reals, Reals]:
    """Return the times of S1 and of S2, in seconds from the first sample of S1."""
    origin_ns = int(series.s1_ns[0])
    return seconds_since(origin_ns, series.s1_ns), seconds_since(origin_ns, series.s2_ns)


def held_s2(series: Series) -> Reals:
    """Return the newest S2 that was known at each S1, NaN before the first, shape (n,)."""
    return np.append(np.nan, series.s2)[series.s2_known]


class Method(NamedTuple):
    """A way to estimate: ours, or one that a user would pick instead.

    Attributes:
        observe_s2: ``(parameters, state, stamp_ns, value) -> state``.
        update: ``(parameters, state, stamp_ns, value) -> (estimate, state)``.
        parameters: What both take, plain numbers in named tuples.
        state: The state before any sample.
    """

    observe_s2: Callable[[Any, State, int, float], State]
    update: Callable[[Any, State, int, float], tuple[Estimate, State]]
    parameters: Any
    state: State


class Trace(NamedTuple):
    """What a method said at each S1 sample; all of shape (n,), strengths (n, 4).

    Attributes:
        mode: WAITING where there is no estimate; the other entries are 0 there.
        value: The estimate.
        aggregate: FA's output.
        weight: W1.
        drift: Magnitude of the drift.
        strengths: Firing strengths in Table 1's order.
        predicted: Whether there was a prediction.
        prediction: The prediction, 0 where there was none.
        accepted: Whether the gate let it count.
    """

    mode: NDArray[np.int64]
    value: Reals
    aggregate: Reals
    weight: Reals
    drift: Reals
    strengths: Reals
    predicted: Flags
    prediction: Reals
    accepted: Flags


def fusion(parameters: Parameters) -> Method:
    """Return the method of this package."""
    return Method(observe_s2, update, numbers(parameters), initial_state(parameters))


def run(method: Method, series: Series) -> Trace:
    """Run a method over a series, step by step as a node would, from its initial state."""
    trace = empty_trace(series.s1.size)
    loop = compiled(_run, observe_s2=method.observe_s2, update=method.update)
    loop(method.parameters, method.state, series, trace)
    return trace


def empty_trace(n: int) -> Trace:
    """Return a trace of ``n`` samples, none of them estimated yet."""
    return Trace(
        mode=np.zeros(n, np.int64),
        value=np.zeros(n),
        aggregate=np.zeros(n),
        weight=np.zeros(n),
        drift=np.zeros(n),
        strengths=np.zeros((n, 4)),
        predicted=np.zeros(n, np.bool_),
        prediction=np.zeros(n),
        accepted=np.zeros(n, np.bool_),
    )


def _run(parameters: Any, state: State, series: Series, trace: Trace) -> None:
    """Feed a series to ``observe_s2`` and ``update``, ours unless bound to another method's."""
    seen = 0
    for k in range(series.s1.size):
        while seen < series.s2_known[k]:
            state = observe_s2(parameters, state, series.s2_ns[seen], series.s2[seen])
            seen += 1
        estimate, state = update(parameters, state, series.s1_ns[k], series.s1[k])
        if estimate.mode != WAITING:
            write(trace, k, estimate)


def write(trace: Trace, k: int, estimate: Estimate) -> None:
    """Write an estimate into row ``k`` of a trace."""
    trace.mode[k] = estimate.mode
    trace.value[k] = estimate.value
    trace.aggregate[k] = estimate.aggregate.value
    trace.weight[k] = estimate.aggregate.weight
    trace.drift[k] = estimate.aggregate.drift
    trace.strengths[k, 0] = estimate.aggregate.strengths.small_small
    trace.strengths[k, 1] = estimate.aggregate.strengths.small_large
    trace.strengths[k, 2] = estimate.aggregate.strengths.large_small
    trace.strengths[k, 3] = estimate.aggregate.strengths.large_large
    trace.predicted[k] = estimate.prediction.exists
    trace.prediction[k] = estimate.prediction.value
    trace.accepted[k] = estimate.accepted
