# SPDX-License-Identifier: Apache-2.0
"""A whole series at once: bit for bit what stepping gives, compiled or not."""

from __future__ import annotations

import math
import sys
from collections import defaultdict

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import signals
from searching import examples

from fuzzy_fusion_ros.baselines.constant_weight import constant_weight
from fuzzy_fusion_ros.baselines.parameters import ConstantWeightParameters
from fuzzy_fusion_ros.batch import series
from fuzzy_fusion_ros.batch.series import (
    Method,
    Series,
    Trace,
    empty_trace,
    fusion,
    held_s2,
    pays_to_compile,
    run,
)
from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY, S2_ONLY, WAITING
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000

VARIANTS: dict[str, dict[str, object]] = {
    "plain": {},
    "predictor": {"predictor.enabled": True},
    "two rules": {"predictor.enabled": True, "predictor.rules": 2},
    "small predictor": {
        "predictor.enabled": True,
        "predictor.samples": 3,
        "predictor.rules": 2,
        "predictor.max_iterations": 20,
        "predictor.error_threshold": 0.0,
    },
    "conditioned": {"s1.lowpass_time_constant": 0.05, "s1.bias_time_constant": 1.0},
    "everything": {
        "predictor.enabled": True,
        "s1.spike_threshold": 0.1,
        "s1.lowpass_time_constant": 0.05,
        "s1.bias_time_constant": 1.0,
        "s1.drift_time_constant": 5.0,
        "s2.lag_time_constant": 0.1,
        "s2.delay": 0.05,
    },
}


def series_of(recording: signals.Recording) -> Series:
    """Return a recording as arrays."""
    return Series(
        s1_ns=np.array([stamp for stamp, _ in recording.s1], np.int64),
        s1=np.array([value for _, value in recording.s1]),
        s2_ns=np.array([stamp for stamp, _ in recording.s2], np.int64),
        s2=np.array([value for _, value in recording.s2]),
        s2_known=np.array(recording.s2_known, np.int64),
    )


def interpreted(method: Method, recorded: Series) -> Trace:
    """Run as ``run`` does, one interpreted step after the other."""
    trace = empty_trace(recorded.s1.size)
    series._run(method.parameters, method.state, recorded, trace, 0, 1)
    return trace


def bits(trace: Trace) -> dict[str, bytes]:
    """Return a trace in a form in which NaN equals NaN and 0 differs from -0."""
    return {name: array.tobytes() for name, array in trace._asdict().items()}


@pytest.mark.parametrize("variant", VARIANTS)
def test_compiled_is_interpreted_bit_for_bit(variant: str) -> None:
    method = fusion(replace(Parameters(), VARIANTS[variant]))
    recorded = series_of(signals.irregular(400, seed=5, gap_ns=2 * SECOND))
    assert bits(run(method, recorded)) == bits(interpreted(method, recorded))


@examples(50)
@given(
    st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=60, max_size=60),
    st.lists(st.integers(1, 300_000_000), min_size=30, max_size=30),
    st.sampled_from(sorted(VARIANTS)),
)
def test_compiled_is_interpreted_bit_for_bit_for_all_that_is_finite(
    values: list[float], steps: list[int], variant: str
) -> None:
    method = fusion(replace(Parameters(), {**VARIANTS[variant], "s2.timeout": 0.5}))
    stamps = SECOND + np.cumsum(np.array(steps, np.int64))
    recorded = Series(
        s1_ns=stamps,
        s1=np.array(values[:30]),
        s2_ns=stamps,
        s2=np.array(values[30:]),
        s2_known=np.arange(1, 31),
    )
    trace = run(method, recorded)
    assert np.isfinite(trace.value).all()
    with np.errstate(all="ignore"):
        assert bits(trace) == bits(interpreted(method, recorded))


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_series_is_stepping_bit_for_bit(variant: str) -> None:
    """Invariant 3, against the steps that a node takes."""
    parameters = replace(Parameters(), VARIANTS[variant])
    recording = signals.irregular(300, seed=6)
    trace = run(fusion(parameters), series_of(recording))
    live = Fusion(parameters)
    taken = 0
    for k, (sample, known) in enumerate(zip(recording.s1, recording.s2_known, strict=True)):
        for s2 in recording.s2[taken:known]:
            assert live.on_s2(Sample(*s2)).estimates == ()
        taken = known
        (fused,) = live.on_s1(Sample(*sample)).estimates
        assert fused.stamp_ns == sample[0]
        said = fused.estimate
        row = (
            fused.stamp_ns,
            said.mode,
            said.value,
            said.aggregate.value,
            said.aggregate.weight,
            said.aggregate.drift,
            said.aggregate.strengths,
            said.prediction.exists,
            said.prediction.value,
            said.accepted,
            said.standard_deviation,
        )
        assert row == tuple(tuple(array[k]) if array.ndim > 1 else array[k] for array in trace), (
            f"sample {k}"
        )


@pytest.mark.parametrize("begin", [0, 1, 250])
@pytest.mark.parametrize("every", [3, 7, 1000])
def test_a_thinned_trace_is_every_so_many_rows_of_the_whole(begin: int, every: int) -> None:
    recorded = series_of(signals.irregular(400, seed=5, gap_ns=2 * SECOND))
    alone = np.arange(0, recorded.s2.size, 4)
    recorded = recorded._replace(s2_alone=alone)
    method = fusion(Parameters())
    whole, thinned = run(method, recorded), run(method, recorded, first=begin, every=every)
    rows = np.arange(whole.value.size) - begin
    assert bits(thinned) == bits(whole.rows((rows >= 0) & (rows % every == 0)))


def test_a_part_of_a_series_is_what_it_holds_there() -> None:
    recorded = series_of(signals.irregular(400, seed=5))
    part = recorded.part(100, 300)
    there = part.s2_known > 0
    assert part.s1.tolist() == recorded.s1[100:300].tolist()
    assert there.any()
    assert held_s2(part)[there].tolist() == held_s2(recorded)[100:300][there].tolist()
    assert part.s2.size == part.s2_known[-1]


def method_of(step_s: float, compiling_s: float) -> Method:
    """Return the fusion as if a step and compiling took these times, seconds."""
    return fusion(Parameters())._replace(step_s=step_s, compiling_s=compiling_s)


@pytest.fixture
def nothing_interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let this process not have interpreted any method yet."""
    monkeypatch.setattr(series, "_INTERPRETED_S", defaultdict(float))


@pytest.mark.usefixtures("nothing_interpreted")
def test_many_short_series_are_compiled_for_like_a_long_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(series, "is_kept", lambda *_, **__: False)
    recorded = series_of(signals.irregular(50, seed=5))
    n = recorded.s1.size
    method = method_of(1.0, 3.0 * n)
    assert pays_to_compile(method, 3 * n)
    for pays in (False, False, True):
        assert pays_to_compile(method, n) == pays
        run(method, recorded, compiles=False)


@pytest.mark.usefixtures("nothing_interpreted")
@pytest.mark.parametrize("imported", [True, False])
@pytest.mark.parametrize("kept", [True, False])
def test_what_is_kept_on_disk_is_used_for_shorter_series(
    kept: bool, imported: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(series, "is_kept", lambda *_, **__: kept)
    monkeypatch.setattr(series, "_LOADING_S" if imported else "_IMPORTING_S", 50.0)
    if imported:
        monkeypatch.setitem(sys.modules, "numba", numba)
    else:
        monkeypatch.delitem(sys.modules, "numba", raising=False)
    method = method_of(1.0, 1e9)
    assert not pays_to_compile(method, 49)
    assert pays_to_compile(method, 50) == kept


@pytest.mark.usefixtures("nothing_interpreted")
@pytest.mark.parametrize("compiles", [True, False])
def test_what_cannot_be_compiled_pays_for_no_import(
    compiles: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(series, "is_kept", lambda *_, **__: True)
    monkeypatch.setattr(series, "_IMPORTING_S", 50.0)
    monkeypatch.delitem(sys.modules, "numba", raising=False)
    recorded = series_of(signals.irregular(50, seed=5))
    interpreted = method_of(1.0, 1e9)._replace(compiles=compiles)
    run(interpreted, recorded, compiles=False)
    assert not pays_to_compile(interpreted._replace(compiles=False), 10**9)
    assert pays_to_compile(constant_weight(ConstantWeightParameters()), 1) == compiles


def test_two_runs_are_the_same_and_leave_the_method_as_it_was() -> None:
    method = fusion(replace(Parameters(), VARIANTS["everything"]))
    recorded = series_of(signals.irregular(200))
    assert bits(run(method, recorded)) == bits(run(method, recorded))


def test_a_series_that_starts_without_s2_is_empty_until_s2_comes() -> None:
    stamps = SECOND + np.arange(5) * 1_000_000
    recorded = Series(
        stamps, np.full(5, 0.5), stamps[3:4], np.array([0.5]), np.array([0, 0, 0, 1, 1])
    )
    trace = interpreted(fusion(Parameters()), recorded)
    assert trace.mode.tolist() == [WAITING] * 3 + [FUSED] * 2
    assert trace.value.tolist() == [0.0] * 3 + [0.5] * 2


def test_a_series_names_the_loss_of_s2() -> None:
    stamps = np.array([1, 2, 8, 9], np.int64) * SECOND
    s2_ns = np.array([1, 9], np.int64) * SECOND
    recorded = Series(stamps, np.full(4, 0.5), s2_ns, np.full(2, 0.5), np.array([1, 1, 1, 2]))
    trace = interpreted(fusion(replace(Parameters(), {"s2.timeout": 5.0})), recorded)
    assert trace.mode.tolist() == [FUSED, FUSED, S1_ONLY, FUSED]
    assert S2_ONLY not in trace.mode


def test_an_empty_series_gives_an_empty_trace() -> None:
    nothing = np.zeros(0)
    none = np.zeros(0, np.int64)
    trace = interpreted(fusion(Parameters()), Series(none, nothing, none, nothing, none))
    assert [array.shape for array in trace] == [(0,)] * 6 + [(0, 4)] + [(0,)] * 4


def test_strengths_of_a_trace_sum_to_one_where_sensors_are_fused() -> None:
    trace = run(fusion(Parameters()), series_of(signals.irregular(300)))
    assert set(trace.mode.tolist()) == {FUSED}
    for strengths in trace.strengths.tolist():
        assert math.fsum(strengths) == pytest.approx(1.0, rel=1e-15)


def test_arrays_of_any_layout_are_compiled_for_once() -> None:
    """As slices of arrays are, and those that may not be written."""
    recorded = series_of(signals.irregular(100, seed=5))
    method = constant_weight(ConstantWeightParameters())
    before = bits(run(method, recorded))
    loop = series.compiled(series._run, **series._bindings(method))
    known = len(loop.signatures)
    twice = np.repeat(recorded.s1_ns, 2)[::2]
    twice.setflags(write=False)
    assert bits(run(method, recorded._replace(s1_ns=twice))) == before
    assert len(loop.signatures) == known
