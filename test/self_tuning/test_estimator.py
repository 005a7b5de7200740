# SPDX-License-Identifier: Apache-2.0
"""The estimator that measures its parameters: when, from what, and without a jump."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples
from tuning.standins import standin

from fuzzy_fusion_ros.batch.arrays import root_mean_square
from fuzzy_fusion_ros.batch.series import Series, fusion, held_s2, run
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.self_tuning.choice import AT_ONCE, MEASURED
from fuzzy_fusion_ros.self_tuning.estimator import (
    ENOUGH,
    SelfTuned,
    initial_state,
    observe_s2,
    update,
)
from fuzzy_fusion_ros.tuning.characterise import characterise

ON = replace(Parameters(), {"self_tuning": True})
SETTLED = 60.0


def steps(series: Series) -> Iterator[tuple[str, int, float]]:
    """The samples of a series in the order in which they came."""
    seen = 0
    for k, known in enumerate(series.s2_known.tolist()):
        while seen < known:
            yield "s2", int(series.s2_ns[seen]), float(series.s2[seen])
            seen += 1
        yield "s1", int(series.s1_ns[k]), float(series.s1[k])


def after(series: Series, parameters: Parameters = ON) -> SelfTuned:
    """The state after a series."""
    kept = initial_state(parameters)
    for sensor, stamp_ns, value in steps(series):
        if sensor == "s2":
            kept = observe_s2(parameters, kept, stamp_ns, value)
        else:
            _, kept = update(parameters, kept, stamp_ns, value)
    return kept


def span(series: Series, seconds: float) -> Series:
    """The first seconds of a series."""
    n = int(np.searchsorted(series.s1_ns, series.s1_ns[0] + round(seconds * 1e9)))
    return series._replace(s1_ns=series.s1_ns[:n], s1=series.s1[:n], s2_known=series.s2_known[:n])


@pytest.fixture(scope="module")
def gyro() -> Series:
    return standin("swings_gyro", 0).series


def test_at_first_it_is_s2_as_held_plus_what_s1_has_moved_since() -> None:
    kept = initial_state(ON)
    kept = observe_s2(ON, kept, 10**9, 5.0)
    values = []
    for k, s1 in enumerate((1.0, 1.5, 0.5)):
        estimate, kept = update(ON, kept, 10**9 + k * 10**7, s1)
        values.append(estimate.value)
    assert values == pytest.approx([5.0, 5.5, 4.5])
    kept = observe_s2(ON, kept, 10**9 + 3 * 10**7, 7.0)
    estimate, kept = update(ON, kept, 10**9 + 4 * 10**7, 0.75)
    assert estimate.value == pytest.approx(7.25)


def test_what_it_measures_is_what_tune_says_of_the_sensors(gyro: Series) -> None:
    parameters, sensors = after(gyro).parameters, characterise(gyro)
    lag = parameters.s2.lag_time_constant + parameters.s2.delay
    assert lag == pytest.approx(sensors.lag.total, rel=0.15)
    assert parameters.s2.noise == pytest.approx(sensors.s2_noise, rel=0.3)
    assert parameters.aggregator.rate.large == pytest.approx(sensors.rate, rel=0.3)
    assert parameters.s1.spike_threshold == 0.0


@pytest.mark.parametrize("name", ["swings_gyro", "ranges_spikes"])
def test_it_is_ahead_of_both_sensors_from_the_second_minute_on(name: str) -> None:
    made = standin(name, 0)
    trace = run(fusion(ON), made.series)
    later = (made.series.s1_ns - made.series.s1_ns[0]) * 1e-9 >= SETTLED
    later &= np.isfinite(made.truth)
    ours, s1, s2 = (
        root_mean_square((each - made.truth)[later])
        for each in (trace.value, made.series.s1, held_s2(made.series))
    )
    assert ours < 0.7 * min(s1, s2)


def test_parameters_change_at_samples_of_s2_at_growing_intervals(gyro: Series) -> None:
    kept, changes = initial_state(ON), []
    for sensor, stamp_ns, value in steps(span(gyro, 60.0)):
        before = kept.parameters
        if sensor == "s2":
            kept = observe_s2(ON, kept, stamp_ns, value)
        else:
            _, kept = update(ON, kept, stamp_ns, value)
        if kept.parameters is not before:
            assert sensor == "s2"
            changes.append(kept.measured.samples)
    assert changes[0] == ENOUGH
    assert len(changes) > 5
    assert all(a <= b for a, b in zip(np.diff(changes), np.diff(changes)[1:], strict=False))


def test_new_parameters_do_not_move_the_estimate(gyro: Series) -> None:
    """Just after a change the estimate is where it would have been without it."""
    kept, moved = initial_state(ON), []
    for sensor, stamp_ns, value in steps(gyro):
        if sensor == "s1":
            _, kept = update(ON, kept, stamp_ns, value)
            continue
        waiting = observe_s2(ON, kept._replace(due=10**9), stamp_ns, value)
        kept = observe_s2(ON, kept, stamp_ns, value)
        if kept.due != waiting.due and kept.parameters is not waiting.parameters:
            belief, other = kept.sensors.belief, waiting.sensors.belief
            smooth, unsmooth = kept.sensors.s1.smooth, waiting.sensors.s1.smooth
            moved.append((smooth.value - belief.states.bias) - (unsmooth.value - other.states.bias))
    assert len(moved) > 5
    assert moved == [0.0] * len(moved)


def test_given_parameters_that_are_not_measured_count_at_once(gyro: Series) -> None:
    kept = after(span(gyro, 20.0))
    changed = replace(ON, {"gate.tolerance": 0.5, "s1.lowpass_time_constant": 7.0})
    _, now = update(changed, kept, int(gyro.s1_ns[-1]), 0.0)
    assert now.parameters.gate.tolerance == 0.5
    assert now.parameters.s1.lowpass_time_constant != 7.0
    early = initial_state(ON)
    _, early = update(changed, early, 10**9, 0.0)
    assert early.parameters.gate.tolerance == 0.5


def test_while_s1_is_silent_nothing_is_learnt(gyro: Series) -> None:
    kept = after(span(gyro, 20.0))
    end_ns = kept.sensors.s1.stamp_ns
    later = kept
    for k in range(100):
        later = observe_s2(ON, later, end_ns + (k + 20) * 10**8, 50.0 * k)
    assert later.measured.errors == kept.measured.errors
    assert later.parameters is kept.parameters


def test_online_it_is_the_run_over_the_whole_series_bit_for_bit(gyro: Series) -> None:
    series = span(gyro, 30.0)
    node = Fusion(ON)
    values = []
    for sensor, stamp_ns, value in steps(series):
        receive = node.on_s1 if sensor == "s1" else node.on_s2
        values += [each.estimate.value for each in receive(Sample(stamp_ns, value)).estimates]
    trace = run(fusion(ON), series)
    assert values == trace.value[trace.mode > 0].tolist()
    assert node.in_use == after(series).parameters
    assert replace(node.in_use, {"self_tuning": False}) != Parameters()


def test_off_it_is_nowhere() -> None:
    node = Fusion(Parameters())
    assert node.in_use is node.parameters
    assert fusion(Parameters()).compiles


def test_all_that_is_measured_is_a_parameter() -> None:
    assert set(MEASURED) <= set(flatten(Parameters()))


@examples(15)
@given(size=st.sampled_from([1e-300, 1e-9, 1e6, 1e150, 1e308]), seed=st.integers(0, 2**31 - 1))
def test_whatever_comes_estimate_and_parameters_are_finite(size: float, seed: int) -> None:
    generator = np.random.default_rng(seed)
    kept = initial_state(ON)
    for k in range(300):
        stamp_ns = 10**9 + k * 10**7
        if k % 3 == 0:
            kept = observe_s2(ON, kept, stamp_ns, size * generator.uniform(-1.0, 1.0))
        estimate, kept = update(ON, kept, stamp_ns, size * generator.uniform(-1.0, 1.0))
        assert math.isfinite(estimate.value)
        assert math.isfinite(estimate.standard_deviation)
    numbers = [each for each in flatten(kept.parameters).values() if isinstance(each, float)]
    assert all(math.isfinite(each) for each in numbers)


def test_an_s1_slower_than_s2_is_no_fault() -> None:
    """As of sensors named the wrong way round: little is known of S1 when S2 is known well."""
    fusion = Fusion(ON)
    fused = []
    for k in range(600):
        stamp_ns = 10**9 + k * 10**8
        verdicts = [fusion.on_s2(Sample(stamp_ns, math.sin(0.05 * k)))]
        if k % 10 == 0:
            verdicts.append(fusion.on_s1(Sample(stamp_ns, math.sin(0.05 * k) + 0.1)))
        fused += [each for verdict in verdicts for each in verdict.estimates]
    assert len(fused) >= 55
    assert all(math.isfinite(each.estimate.value) for each in fused)


def test_the_standard_deviation_is_one_also_while_s2_sets_the_bias_at_once() -> None:
    """A gyro and a late course: single samples of S2 are best now and then."""
    rng = np.random.default_rng(3)
    kept, errors, said, at_once = initial_state(ON), [], [], 0
    for k in range(12_000):
        time_s, stamp_ns = 0.01 * k, 10**9 + k * 10**7
        heading, late = (0.3 * at + 1.2 * math.sin(0.4 * at) for at in (time_s, time_s - 0.3))
        if k % 100 == 0:
            kept = observe_s2(ON, kept, stamp_ns, late + 0.02 * rng.normal())
        estimate, kept = update(ON, kept, stamp_ns, heading + 0.01 * time_s)
        if time_s > 20.0:
            at_once += kept.parameters.s1.bias_time_constant <= AT_ONCE
            errors.append(estimate.value - heading)
            said.append(estimate.standard_deviation)
    assert 1000 < at_once < 9000
    assert min(said) > 0.2 * root_mean_square(np.array(errors))
    assert max(said) < 5.0 * root_mean_square(np.array(errors))
