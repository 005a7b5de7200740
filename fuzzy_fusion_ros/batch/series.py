# SPDX-License-Identifier: Apache-2.0
"""A whole recording at once: the estimator's steps over arrays, compiled where possible."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps, seconds_since
from fuzzy_fusion_ros.batch.compiled import (
    can_compile,
    compiled,
    given_back,
    interpreted,
    is_kept,
    taken_by,
)
from fuzzy_fusion_ros.core.estimator import (
    WAITING,
    Estimate,
    observe_s2,
    update,
    without_s1,
)
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.core.silence import followed
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import numbers
from fuzzy_fusion_ros.self_tuning import estimator_for

State = Any
"""State of a method; each method has its own type."""

_AGGREGATOR_S, _OBSERVER_S, _PREDICTOR_S = 1.5e-5, 3e-5, 8e-5
"""CPU time of a part of the fusion in an interpreted step, seconds: about, as the next."""

_COMPILING_S = 20.0
"""CPU time of compiling a loop over the fusion, seconds."""

_IMPORTING_S, _LOADING_S = 0.6, 0.04
"""CPU time to import numba, and to load a loop that an earlier process has compiled, seconds."""

_INTERPRETED_S: defaultdict[Callable[..., Any], float] = defaultdict(float)
"""CPU time for which each method's ``update`` has been interpreted in this process, seconds."""

NOWHERE: Stamps = np.empty(0, np.int64)
"""No index at all."""


class Series(NamedTuple):
    """Samples of both sensors, each with its own stamps, and what was known when.

    Attributes:
        s1_ns: Stamps of S1, rising, shape (n,), nanoseconds.
        s1: Samples of S1, finite, shape (n,).
        s2_ns: Stamps of S2, rising, shape (m,), nanoseconds.
        s2: Samples of S2, finite, shape (m,).
        s2_known: How many samples of S2 had come before each of S1, not falling, shape (n,).
        s2_alone: Indices of the S2 samples at which an estimate is due because S1 is lost, rising,
            shape (k,).
        started_ns: Stamp of the first sample of S1, from which on S2 is awaited, nanoseconds; 0
            for the first of ``s1_ns``.
    """

    s1_ns: Stamps
    s1: Reals
    s2_ns: Stamps
    s2: Reals
    s2_known: Stamps
    s2_alone: Stamps = NOWHERE
    started_ns: int = 0

    def contiguous(self) -> Series:
        """Return the same samples as compiled loops take them, which are compiled for one layout.

        Arrays that are writable and contiguous already are not copied.
        """
        arrays = (np.require(each, requirements=["C", "W"]) for each in self[:-1])
        return Series._make([*arrays, self.started_ns])

    def at_s1(self) -> Series:
        """Return the same samples with estimates at samples of S1 only."""
        return self._replace(s2_alone=NOWHERE)

    def part(self, begin: int, end: int) -> Series:
        """Return a copy of the samples of S1 from ``begin`` to before ``end``, and S2's among them.

        Args:
            begin: Index of the first sample of S1.
            end: Index after the last one.
        """
        known = self.s2_known[begin:end]
        heard = slice(int(known[0]), int(known[-1]))
        return Series(
            s1_ns=self.s1_ns[begin:end].copy(),
            s1=self.s1[begin:end].copy(),
            s2_ns=self.s2_ns[heard].copy(),
            s2=self.s2[heard].copy(),
            s2_known=known - known[0],
        )


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
        update: ``(parameters, state, stamp_ns, value) -> (estimate, state)``, at a sample of S1.
        without_s1: ``(parameters, state, stamp_ns) -> estimate`` at a sample of S2 that has been
            observed, S1 being lost.
        parameters: What they take, plain numbers in named tuples.
        state: The state before any sample.
        compiles: Whether its functions can be compiled.
        step_s: CPU time of an interpreted step, seconds: about, as the next.
        compiling_s: CPU time of compiling a loop over it, seconds.
    """

    observe_s2: Callable[[Any, State, int, float], State]
    update: Callable[[Any, State, int, float], tuple[Estimate, State]]
    without_s1: Callable[[Any, State, int], Estimate]
    parameters: Any
    state: State
    compiles: bool = True
    step_s: float = 1e-5
    compiling_s: float = 2.0


class Trace(NamedTuple):
    """What a method said at each sample at which an estimate was due, in order.

    These are the samples of S1 and, where S1 is lost, of S2. All of shape (n,), strengths (n, 4).

    Attributes:
        stamp_ns: Stamp of the sample, nanoseconds.
        mode: WAITING where there is no estimate; the other entries are 0 there.
        value: The estimate.
        aggregate: FA's output.
        weight: W1.
        drift: Magnitude of the drift.
        strengths: Firing strengths in Table 1's order.
        predicted: Whether there was a prediction.
        prediction: The prediction, 0 where there was none.
        accepted: Whether the gate let it count.
        standard_deviation: Of the estimate's error, 0 where nothing is known.
    """

    stamp_ns: Stamps
    mode: NDArray[np.int64]
    value: Reals
    aggregate: Reals
    weight: Reals
    drift: Reals
    strengths: Reals
    predicted: Flags
    prediction: Reals
    accepted: Flags
    standard_deviation: Reals

    def rows(self, chosen: Flags) -> Trace:
        """Return some of the rows, shape (n,) says which."""
        return Trace._make([column[chosen] for column in self])

    def known(self, values: Reals) -> Reals:
        """Return ``values``, shape (n,), NaN at samples at which there is no estimate."""
        return np.where(self.mode == WAITING, np.nan, values)


def fusion(parameters: Parameters, started_ns: int = 0) -> Method:
    """Return the method of this package.

    Args:
        parameters: Of the fusion.
        started_ns: As in :class:`Series`.
    """
    own = estimator_for(parameters)
    learning_s = _OBSERVER_S * observes(parameters) + _PREDICTOR_S * parameters.predictor.enabled
    given = parameters if parameters.self_tuning else numbers(parameters)
    state = own.initial_state(parameters)._replace(started_ns=started_ns)
    return Method(
        own.observe_s2,
        own.update,
        own.without_s1,
        given,
        state,
        compiles=not parameters.self_tuning,
        step_s=_AGGREGATOR_S + learning_s,
        compiling_s=_COMPILING_S,
    )


def run(
    method: Method, series: Series, *, compiles: bool = True, first: int = 0, every: int = 1
) -> Trace:
    """Run a method over a series, step by step as a node would, from its initial state.

    Args:
        method: The method.
        series: The samples.
        compiles: Whether to compile the loop, if the method can be; the result is the same to the
            last bit.
        first: The first row, one for each sample of S1 and of ``s2_alone``, that the trace keeps.
        every: Of this many rows from it on the trace keeps one, to save memory.
    """
    trace, _ = advanced(method, series, compiles=compiles, first=first, every=every)
    return trace


def run_economically(method: Method, series: Series, *, first: int = 0, every: int = 1) -> Trace:
    """Run a method over a series as :func:`run` does, compiled if that pays."""
    compiles = pays_to_compile(method, series.s1.size)
    return run(method, series, compiles=compiles, first=first, every=every)


def trace_at_s1(parameters: Parameters, series: Series) -> Trace:
    """Return what the fusion says at each sample of S1, compiled if that pays."""
    return run_economically(fusion(parameters, series.started_ns), series.at_s1())


def advanced(
    method: Method, series: Series, *, compiles: bool, first: int = 0, every: int = 1
) -> tuple[Trace, State]:
    """Run a method over a part of a series; return what it says, and the state after it.

    Args:
        method: The method, with the state before the part.
        series: The part.
        compiles: Whether to compile the loop, if the method can be; the result is the same.
        first: As in :func:`run`.
        every: As in :func:`run`.
    """
    trace = empty_trace(-(-(series.s1.size + series.s2_alone.size - first) // every))
    if method.compiles and compiles:
        loop = compiled(_run, **_bindings(method))
        state = taken_by(loop, method.state)
        state = loop(method.parameters, state, series.contiguous(), trace, first, every)
        return trace, given_back(state, method.state)
    if method.compiles:
        _INTERPRETED_S[method.update] += method.step_s * series.s1.size
    plain = Series._make([*(each.tolist() for each in series[:-1]), series.started_ns])
    loop = interpreted(_run, **_bindings(method))
    return trace, loop(method.parameters, method.state, plain, trace, first, every)


def pays_to_compile(method: Method, samples: int) -> bool:
    """Return whether to compile a method for a run over n samples of S1.

    It is once it has been interpreted, with that run, for as long as compiling takes: many short
    series are worth it like a long one. Where an earlier process has compiled it, it is once that
    time is as long as loading takes: of the method alone if numba is imported, else of all
    methods together, as they share the import.
    """
    if not method.compiles or not can_compile():
        return False
    run_s = method.step_s * samples
    own_s = _INTERPRETED_S[method.update] + run_s
    if own_s >= method.compiling_s:
        return True
    if "numba" in sys.modules:
        pays_to_load = own_s >= _LOADING_S
    else:
        pays_to_load = sum(_INTERPRETED_S.values()) + run_s >= _IMPORTING_S
    return pays_to_load and is_kept(_run, **_bindings(method))


def interval_after(interval: float, newest_ns: int, stamps_ns: Stamps, *, compiles: bool) -> float:
    """Return the interval of a sensor, as :func:`followed`, after more samples, seconds.

    Args:
        interval: That before them.
        newest_ns: Stamp of the sample before them, nanoseconds.
        stamps_ns: Their stamps, shape (n,), nanoseconds.
        compiles: Whether to compile the loop; the result is the same.
    """
    if compiles:
        return float(compiled(_follow)(interval, newest_ns, stamps_ns))
    return _follow(interval, newest_ns, stamps_ns.tolist())


def _follow(interval: float, newest_ns: int, stamps_ns: Any) -> float:
    for stamp_ns in stamps_ns:
        interval = followed(interval, seconds_between(newest_ns, stamp_ns))
        newest_ns = stamp_ns
    return interval


def _bindings(method: Method) -> dict[str, Callable[..., Any]]:
    return {
        "observe_s2": method.observe_s2,
        "update": method.update,
        "without_s1": method.without_s1,
    }


def values(method: Method, series: Series) -> Reals:
    """Run a method over a series; return only its estimates at S1, 0 where it waits, shape (n,).

    Instead of ``run`` for fits, which take thousands of runs, and for recordings of which a trace,
    thirteen times as large, would not fit into memory; with the same values to the last bit.

    Args:
        method: The method.
        series: The samples.
    """
    found = np.zeros(series.s1.size)
    if method.compiles:
        loop = compiled(_values, observe_s2=method.observe_s2, update=method.update)
        loop(method.parameters, taken_by(loop, method.state), series.at_s1().contiguous(), found)
        return found
    return run(method, series.at_s1()).value


def empty_trace(n: int) -> Trace:
    """Return a trace of ``n`` samples, none of them estimated yet."""
    return Trace(
        stamp_ns=np.zeros(n, np.int64),
        mode=np.zeros(n, np.int64),
        value=np.zeros(n),
        aggregate=np.zeros(n),
        weight=np.zeros(n),
        drift=np.zeros(n),
        strengths=np.zeros((n, 4)),
        predicted=np.zeros(n, np.bool_),
        prediction=np.zeros(n),
        accepted=np.zeros(n, np.bool_),
        standard_deviation=np.zeros(n),
    )


def _run(
    parameters: Any, state: State, series: Series, trace: Trace, first: int, every: int
) -> State:
    """Feed a series to ``observe_s2`` and ``update``, ours unless bound to another method's."""
    seen = 0
    alone = 0
    for k in range(len(series.s1) + 1):
        known = series.s2_known[k] if k < len(series.s1) else len(series.s2)
        while seen < known:
            state = observe_s2(parameters, state, series.s2_ns[seen], series.s2[seen])
            if alone < len(series.s2_alone) and series.s2_alone[alone] == seen:
                stamp_ns = series.s2_ns[seen]
                row = k + alone - first
                if row >= 0 and row % every == 0:
                    estimate = without_s1(parameters, state, stamp_ns)
                    write(trace, row // every, stamp_ns, estimate)
                alone += 1
            seen += 1
        if k < len(series.s1):
            estimate, state = update(parameters, state, series.s1_ns[k], series.s1[k])
            row = k + alone - first
            if row >= 0 and row % every == 0:
                write(trace, row // every, series.s1_ns[k], estimate)
    return state


def _values(parameters: Any, state: State, series: Series, found: Reals) -> None:
    """Feed a series to ``observe_s2`` and ``update``; keep the estimates alone."""
    seen = 0
    for k in range(series.s1.size):
        while seen < series.s2_known[k]:
            state = observe_s2(parameters, state, series.s2_ns[seen], series.s2[seen])
            seen += 1
        estimate, state = update(parameters, state, series.s1_ns[k], series.s1[k])
        if estimate.mode != WAITING:
            found[k] = estimate.value


def write(trace: Trace, k: int, stamp_ns: int, estimate: Estimate) -> None:
    """Write what there is at a stamp into row ``k`` of a trace; nothing but it while WAITING."""
    trace.stamp_ns[k] = stamp_ns
    if estimate.mode == WAITING:
        return
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
    trace.standard_deviation[k] = estimate.standard_deviation
