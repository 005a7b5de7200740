# SPDX-License-Identifier: Apache-2.0
"""The observer: what it believes of S1's bias, and how far it believes S2."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import signals
from reference.observer import observed

from fuzzy_fusion_ros.core.aggregator import no_slow_sensor
from fuzzy_fusion_ros.core.conditioning import FastSensor, begun
from fuzzy_fusion_ros.core.deviation import FIRST
from fuzzy_fusion_ros.core.estimator import (
    FUSED,
    S1_ONLY,
    Estimate,
    State,
    initial_state,
    observe_s2,
    update,
    without_s1,
)
from fuzzy_fusion_ros.core.model import no_states
from fuzzy_fusion_ros.core.observer import LASTING, LONGEST, LOST, doubt_in, moved_on, no_belief
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace

SECOND = 1_000_000_000
STEP = 10_000_000

QUIET = {
    "aggregator.difference.small": 1e8,
    "aggregator.difference.large": 1e9,
    "aggregator.rate.large": 1e9,
    **{f"aggregator.weight.{each}": 0.0 for each in ("very_small", "small", "large", "very_large")},
}
"""Rules that never fire but *small, small*, and believe S2 wholly."""

LEARNING = replace(
    Parameters(),
    {**QUIET, "s1.bias_time_constant": 2.0, "s1.bias_prior": 1.0, "s2.noise": 0.1},
)


def fed(
    parameters: Parameters,
    s1: list[float],
    s2: list[float],
    every: int = 1,
    state: State | None = None,
    start_ns: int = SECOND,
) -> tuple[list[Estimate], State]:
    """Feed samples at 100 Hz, one of S2 before every so many of S1."""
    state = state or initial_state(parameters)
    said = []
    for k, value in enumerate(s1):
        stamp_ns = start_ns + k * STEP
        if k % every == 0 and k // every < len(s2):
            state = observe_s2(parameters, state, stamp_ns, s2[k // every])
        estimate, state = update(parameters, state, stamp_ns, value)
        said.append(estimate)
    return said, state


def values(said: list[Estimate]) -> list[float]:
    """Return the estimates' values."""
    return [each.value for each in said]


EVERYTHING = replace(
    Parameters(),
    {
        "aggregator.difference.small": 0.05,
        "aggregator.difference.large": 0.4,
        "aggregator.rate.large": 3.0,
        "s1.bias_time_constant": 0.5,
        "s1.bias_prior": 0.2,
        "s1.drift_time_constant": 3.0,
        "s1.drift_prior": 0.1,
        "s2.noise": 0.02,
        "s2.lag_time_constant": 0.07,
        "s2.delay": 0.03,
    },
)


@pytest.mark.parametrize("recording", [signals.regular(400), signals.irregular(400)])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"s2.lag_time_constant": 0.0, "s2.delay": 0.0},
        {"s1.drift_time_constant": 0.0},
        {"s1.drift_prior": 0.0},
    ],
)
def test_it_is_the_reference_s(recording: signals.Recording, changes: dict[str, float]) -> None:
    parameters = replace(EVERYTHING, changes)
    state = initial_state(parameters)
    seen, said = 0, []
    for (stamp_ns, value), known in zip(recording.s1, recording.s2_known, strict=True):
        for s2_ns, s2 in recording.s2[seen:known]:
            state = observe_s2(parameters, state, s2_ns, s2)
        seen = known
        estimate, state = update(parameters, state, stamp_ns, value)
        said.append(estimate)
    exact = observed(parameters, recording.s1, recording.s2, recording.s2_known)
    assert values(said) == pytest.approx(exact, rel=1e-9, abs=1e-12)


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.0, 0.99))
def test_without_lag_and_knowing_nothing_it_is_the_paper_s_blend(
    s1: float, s2: float, w1: float
) -> None:
    """At the first sample, where S2's noise is as large as S1's bias may be."""
    levels = {f"aggregator.weight.{each}": w1 for each in ("small", "large", "very_large")}
    blind = replace(LEARNING, {**levels, "s1.bias_prior": 0.1})
    (said,), _ = fed(blind, [s1], [s2])
    # K = 1 / (1 + 1 / (1 - W1)^2): S2's share; the blend's is 1 - W1
    share = 1.0 / (1.0 + 1.0 / (1.0 - w1) ** 2)
    assert said.value == pytest.approx((1.0 - share) * s1 + share * s2, abs=1e-9)
    assert said.aggregate.weight == pytest.approx(1.0 - share)
    assert said.aggregate.drift == 0.0
    (said,), _ = fed(replace(blind, {"s1.bias_prior": 0.0}), [s1], [s2])
    assert said.value == pytest.approx(s2, abs=1e-4 * (1.0 + abs(s1 - s2)))


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_the_bias_is_learnt_with_its_time_constant(noise: float) -> None:
    parameters = replace(LEARNING, {"s2.noise": noise})
    _, state = fed(parameters, [0.0] * 3000, [0.0] * 3000)
    said, _ = fed(parameters, [1.0] * 201, [0.0] * 201, state=state, start_ns=31 * SECOND)
    assert said[-1].value == pytest.approx(math.exp(-1.0), abs=0.01)
    assert said[-1].aggregate.weight == pytest.approx(1.0 - 0.005, abs=1e-4)  # interval / T


def test_the_bias_is_a_mean_at_first() -> None:
    noise = np.random.default_rng(0).normal(0.3, 0.1, 400).tolist()
    slow = replace(LEARNING, {"s1.bias_time_constant": 1e6})
    _, state = fed(slow, noise, [0.0] * 400)
    assert state.sensors.belief.states.bias == pytest.approx(float(np.mean(noise)), abs=0.01)


def test_the_prior_holds_a_first_sample_that_is_far_off() -> None:
    """Of S2: it says as much as its noise and the prior let it."""
    parameters = replace(LEARNING, {"s1.bias_prior": 0.1})
    (said,), _ = fed(parameters, [0.0], [3.4])
    assert said.value == pytest.approx(1.7)
    (said,), _ = fed(replace(parameters, {"s1.bias_prior": 0.01}), [0.0], [3.4])
    assert said.value == pytest.approx(3.4 / 101.0)


def test_a_slope_that_was_expected_is_known_after_a_few_samples() -> None:
    """A gyro's bias, integrated: without a prior only fast learning would find it soon."""
    slow = replace(LEARNING, {"s1.bias_time_constant": 100.0, "s1.drift_time_constant": 1000.0})
    drifting = (0.5 * np.arange(300) * 0.01).tolist()
    for prior, at_most in ((0.0, math.inf), (0.5, 0.02)):
        said, state = fed(replace(slow, {"s1.drift_prior": prior}), drifting, [0.0] * 300)
        assert (abs(said[-1].value) < 0.02) == (prior > 0.0)
        assert abs(state.sensors.belief.states.slope - 0.5) < at_most


@pytest.mark.parametrize("ignored", ["s2.noise", "s1.drift_time_constant"])
def test_a_prior_of_the_slope_needs_the_noise_and_the_slope(ignored: str) -> None:
    parameters = replace(LEARNING, {"s1.drift_time_constant": 5.0, ignored: 0.0})
    with_prior = replace(parameters, {"s1.drift_prior": 0.5})
    drifting = (0.5 * np.arange(100) * 0.01).tolist()
    (plain, _), (said, _) = (fed(each, drifting, [0.0] * 100) for each in (parameters, with_prior))
    assert values(said) == values(plain)


def test_microseconds_are_as_good_as_seconds() -> None:
    """The same in another unit of time: only rounding and the clock's nanoseconds differ."""

    def estimates(unit: float) -> list[float]:
        times = ("s1.bias_time_constant", "s1.drift_time_constant", "s2.lag_time_constant")
        given = {name: flatten(EVERYTHING)[name] for name in (*times, "s2.delay")}
        parameters = replace(
            EVERYTHING,
            {
                **{name: float(value) * unit for name, value in given.items()},
                "s1.drift_prior": 0.5 / unit,
                "s2.noise": 0.001,
                "aggregator.rate.small": 0.01 / unit,
                "aggregator.rate.large": 3.0 / unit,
                "aggregator.rate_time_constant": 0.1 * unit,
            },
        )
        state, said = initial_state(parameters), []
        for k in range(400):
            stamp_ns = SECOND + round(k * STEP * unit)
            x = math.sin(k * 0.01)
            if k % 5 == 0:
                state = observe_s2(parameters, state, stamp_ns, x)
            estimate, state = update(parameters, state, stamp_ns, x + 0.5 * k * 0.01)
            said.append(estimate)
        return values(said)

    assert estimates(1e-5) == pytest.approx(estimates(1.0), abs=1e-9)


@pytest.mark.parametrize(("lag", "delay"), [(0.3, 0.0), (0.0, 0.2), (0.3, 0.2)])
def test_s2_s_lag_is_no_error_of_s1(lag: float, delay: float) -> None:
    model = {"s2.lag_time_constant": lag, "s2.delay": delay}
    truth = np.sin(np.arange(3000) * 0.01).tolist()
    first, behind = 0.0, [0.0] * (1 + round(delay / 0.01))  # S2 comes before S1
    for x in truth:
        first += (1.0 - math.exp(-0.01 / lag) if lag else 1.0) * (x - first)
        behind.append(first)
    s2 = behind[: len(truth)]
    biased = [x + 0.5 for x in truth]
    with_model, _ = fed(replace(LEARNING, model), biased, s2)
    without, _ = fed(LEARNING, biased, s2)
    late = np.abs(np.subtract(values(without), truth))[1000:]
    assert np.abs(np.subtract(values(with_model), truth))[1000:].max() < 0.005
    assert late.max() > 0.05


@pytest.mark.parametrize("late", [0.0, 0.2, 1.0])
def test_an_s2_that_arrives_late_says_how_it_was_at_its_stamp(late: float) -> None:
    """By a time that varies, too."""
    truth = np.sin(np.arange(3000) * 0.01)
    arrives = np.arange(0, 3000, 10) + np.round(
        100 * late * np.random.default_rng(0).uniform(0.5, 1.0, 300)
    )
    state, said = initial_state(LEARNING), []
    waiting = sorted(zip(arrives.tolist(), range(0, 3000, 10), strict=True))
    newest = -1
    for k, x in enumerate(truth.tolist()):
        while waiting and waiting[0][0] <= k:
            _, measured = waiting.pop(0)
            if measured > newest:
                newest = measured
                at_ns = SECOND + measured * STEP
                state = observe_s2(LEARNING, state, at_ns, float(truth[measured]))
        estimate, state = update(LEARNING, state, SECOND + k * STEP, x + 0.5)
        said.append(estimate)
    assert np.abs(np.subtract(values(said), truth))[500:].max() < 0.02


def test_an_innovation_through_a_lag_stands_for_more_than_itself() -> None:
    lagging = replace(LEARNING, {"s2.lag_time_constant": 0.3})
    _, state = fed(lagging, [0.0] * 100, [0.0] * 100, every=10)
    said, _ = fed(lagging, [0.0], [0.5], state=state, start_ns=2 * SECOND)
    fa = said[0].aggregate
    assert said[0].value == pytest.approx((1.0 - fa.weight) * 0.5 + fa.drift, rel=1e-6)
    assert fa.drift > 0.0


def test_a_drifting_bias_is_followed_along_its_slope() -> None:
    s1 = [0.001 * k for k in range(6000)]  # 0.1 a second
    lag = values(fed(LEARNING, s1, [0.0] * 6000)[0])[-1]
    sloped = replace(LEARNING, {"s1.drift_time_constant": 5.0})
    said, state = fed(sloped, s1, [0.0] * 6000)
    assert lag == pytest.approx(0.2, rel=0.05)
    assert said[-1].value == pytest.approx(0.0, abs=0.01)
    assert state.sensors.belief.states.slope == pytest.approx(0.1, rel=0.05)
    alone, _ = fed(sloped, [6.0 + 0.1 * 2.0], [], state=state, start_ns=63 * SECOND - STEP)
    assert alone[0].value == pytest.approx(0.0, abs=0.05)  # believed while S2 is silent


def test_a_slope_is_learnt_with_its_time_constant() -> None:
    """Two poles, the slower of which is that of the slope."""
    sloped = replace(LEARNING, {"s1.bias_time_constant": 0.2, "s1.drift_time_constant": 4.0})
    _, state = fed(sloped, [0.0] * 6000, [0.0] * 6000)
    ramp = [0.001 * k for k in range(401)]
    _, state = fed(sloped, ramp, [0.0] * 401, state=state, start_ns=61 * SECOND)
    assert state.sensors.belief.states.slope == pytest.approx(0.1 * (1.0 - math.exp(-1.0)), rel=0.1)


def test_where_the_rules_say_so_s2_is_not_believed() -> None:
    moving = replace(
        LEARNING,
        {"aggregator.rate.large": 1.0, "aggregator.rate_time_constant": 0.0},
    )
    doubting = replace(
        moving, {"aggregator.weight.large": 0.9, "aggregator.weight.very_large": 0.99}
    )
    _, still = fed(moving, [0.0] * 100, [0.0] * 100)
    jump = [0.5] * 2
    (first, *_), _ = fed(moving, jump, jump, state=still, start_ns=2 * SECOND)
    (doubted, *_), _ = fed(doubting, jump, jump, state=still, start_ns=2 * SECOND)
    assert first.aggregate.strengths.small_large == 1.0
    assert doubted.aggregate.weight > first.aggregate.weight


def test_a_difference_beyond_all_others_says_that_s1_has_gone_wrong() -> None:
    net = replace(
        LEARNING, {"aggregator.difference.small": 1.0, "aggregator.difference.large": 2.0}
    )
    _, state = fed(net, [0.0] * 1000, [0.0] * 1000)
    wrong = [5.0] * 3
    lost, _ = fed(LEARNING, wrong, [0.0] * 3, state=state, start_ns=12 * SECOND)
    caught, _ = fed(net, wrong, [0.0] * 3, state=state, start_ns=12 * SECOND)
    assert lost[-1].value > 4.0
    assert abs(caught[-1].value) < 0.1
    assert caught[0].aggregate.strengths.large_small == pytest.approx(1.0)
    unknown = replace(net, {"s2.noise": 0.0})  # nothing to compare the difference with
    assert fed(unknown, wrong, [0.0] * 3, state=state, start_ns=12 * SECOND)[0][-1].value > 4.0


SPIKES = replace(LEARNING, {"s1.spike_threshold": 0.5, "s2.lag_time_constant": 0.2})


def through_lag(signal: list[float]) -> list[float]:
    """Return S2 of a signal at 100 Hz: behind its lag, and a sample late."""
    seen, found = signal[0], []
    for x in signal:
        found.append(seen)
        seen += (1.0 - math.exp(-0.01 / 0.2)) * (x - seen)
    return found


def test_however_long_a_fault_lasts_s2_is_not_contradicted() -> None:
    """Until S1's timeout; then the bias takes the step."""
    truth = [0.0] * 1000
    faulty = [*truth[:500], *[4.0] * 500]
    said, state = fed(SPIKES, faulty, truth)
    assert np.abs(values(said)).max() < 0.01
    assert state.sensors.belief.states.bias == pytest.approx(4.0, abs=0.01)
    assert state.sensors.s1.smooth.rejected == 0.0


def test_a_step_of_the_signal_passes_when_s2_begins_to_follow() -> None:
    truth = [*[0.0] * 500, *[4.0] * 200]
    said, _ = fed(SPIKES, truth, through_lag(truth))
    late = np.flatnonzero(np.abs(np.subtract(values(said), truth)) > 0.2)
    assert late.size < 10  # 0.1 s, half of S2's lag
    assert values(said)[-1] == pytest.approx(4.0, abs=0.05)
    _, state = fed(SPIKES, truth[:503], through_lag(truth[:503]))  # two samples of S2 that move
    assert state.sensors.s1.smooth.rejected == 0.0
    assert state.sensors.belief.innovation == pytest.approx(0.0, abs=0.01)


def test_while_s1_is_rejected_the_estimate_goes_along_with_s2() -> None:
    truth = [0.01 * k for k in range(1000)]
    faulty = [*truth[:500], *[-4.0] * 80, *truth[580:]]
    said, _ = fed(SPIKES, faulty, through_lag(truth))
    assert np.abs(np.subtract(values(said), truth))[100:].max() < 0.1


@pytest.mark.parametrize("spike", [9.0, -90.0])
def test_a_spike_does_not_enter_the_model_of_s2(spike: float) -> None:
    steady = [1.0] * 50
    said, state = fed(SPIKES, [*steady, spike, *steady], [1.0] * 101)
    assert values(said) == pytest.approx([1.0] * 101)
    assert state.sensors.belief.states.shown.lagged == pytest.approx(1.0)


def test_a_gap_of_s1_keeps_the_bias_and_restarts_the_model_of_s2() -> None:
    lagging = replace(LEARNING, {"s1.timeout": 1.0, "s2.lag_time_constant": 5.0})
    _, state = fed(lagging, [1.5] * 3000, [1.0] * 3000)
    late_ns = 31 * SECOND + 3 * SECOND
    state = observe_s2(lagging, state, late_ns, 7.0)
    # S1 is silent: not learnt
    assert state.sensors.belief.states.bias == pytest.approx(0.5, abs=0.05)
    said, state = update(lagging, state, late_ns, 7.5)
    assert said.value == pytest.approx(7.0, abs=0.05)
    assert state.sensors.belief.states.shown.lagged == 7.5


@pytest.mark.parametrize("noise", [0.0, 1e-6, 0.1])
def test_after_a_gap_of_a_rate_its_integral_is_little_known(noise: float) -> None:
    """By how far S2 leads, but for a variance in which rounding would show afterwards."""
    parameters = replace(LEARNING, {"s1.kind": "rate", "s2.noise": noise})
    line = [0.01 * k for k in range(100)]
    _, state = fed(parameters, line, line)
    for k in range(100, 300):
        state = observe_s2(parameters, state, SECOND + k * STEP, 0.01 * k)
    known = state.sensors.belief.covariance.cc
    estimate, state = update(parameters, state, SECOND + 349 * STEP, 2.5)
    belief = state.sensors.belief
    assert estimate.value == pytest.approx(3.49, abs=0.01)  # where S2 leads
    assert known < belief.covariance.cc <= 1.0 + LOST * LOST
    if noise == 0.1:
        assert belief.covariance.cc > 1.0 + 0.2  # squares of the noise: it may be 0.5 behind


def test_where_s2_leads_is_unknown_as_long_as_its_noise_is() -> None:
    assert doubt_in(0.3, usual=0.01, noise=0.2) == pytest.approx(9.0)
    assert doubt_in(0.3, usual=0.0, noise=0.1) == pytest.approx(9.0)
    assert doubt_in(0.3, usual=0.0, noise=0.0) == LOST * LOST


def test_the_delay_does_not_reach_across_a_gap_of_s1() -> None:
    parameters = replace(LEARNING, {"s1.timeout": 1.0, "s2.timeout": 10.0, "s2.delay": 0.5})
    _, state = fed(parameters, [0.0] * 100, [0.0] * 100)
    _, state = fed(parameters, [4.0], [], state=state, start_ns=4 * SECOND)
    state = observe_s2(parameters, state, 4 * SECOND + STEP, 4.0)
    assert state.sensors.belief.innovation == 0.0


def test_an_s2_that_is_lost_leaves_s1_less_its_bias() -> None:
    lost = replace(LEARNING, {"s2.timeout": 0.5})
    said, _ = fed(lost, [1.5] * 400, [1.0] * 300)
    assert (said[299].mode, said[-1].mode) == (FUSED, S1_ONLY)
    assert said[-1].value == pytest.approx(1.0, abs=1e-4)
    assert said[-1].aggregate.weight == 1.0


@given(st.lists(st.tuples(st.floats(-1.7e308, 1.7e308), st.floats(-1.7e308, 1.7e308)), max_size=30))
def test_what_is_finite_stays_finite(samples: list[tuple[float, float]]) -> None:
    extreme = replace(
        SPIKES, {"s1.bias_time_constant": 1e-9, "s1.drift_time_constant": 1e-9, "s2.noise": 1e-9}
    )
    for parameters in (
        EVERYTHING,
        SPIKES,
        extreme,
        replace(extreme, {"s2.outlier_threshold": 1.0}),
    ):
        said, _ = fed(parameters, [a for a, _ in samples], [b for _, b in samples])
        for each in said:
            assert np.isfinite((each.value, *each.aggregate[:3])).all()
            assert 0.0 <= each.aggregate.weight <= 1.0


def sensor(stamp_ns: int, value: float, samples: int) -> FastSensor:
    return FastSensor(samples, stamp_ns, 0.01, begun(value))


def test_a_gap_of_s1_takes_the_slope_once() -> None:
    """The bias has been moved on to S1's last sample, whenever S2 spoke last."""
    states = no_states()._replace(bias=1.0, slope=0.1)
    kept = no_belief()._replace(stamp_ns=10 * SECOND, states=states)
    before, s1 = sensor(30 * SECOND, 0.0, 9), sensor(40 * SECOND, 0.0, 1)
    moved = moved_on(LEARNING, kept, before, s1, no_slow_sensor(), 0.0)
    assert moved.states.bias == pytest.approx(2.0)


def test_a_sample_of_s2_from_before_s1_was_not_late() -> None:
    state = observe_s2(LEARNING, initial_state(LEARNING), SECOND, 1.0)
    _, state = update(LEARNING, state, 5 * SECOND, 1.0)
    belief = state.sensors.belief
    assert (belief.samples, belief.late) == (1, 0.0)
    state = observe_s2(LEARNING, state, 4 * SECOND, 1.0)
    assert state.sensors.belief.late == 1.0


def test_evidence_begins_again_where_the_observer_is_switched() -> None:
    """The blend weighs innovations by 1, the observer by what it expects."""
    _, state = fed(Parameters(), [3.0] * 50, [0.0] * 5, every=10)
    assert state.sensors.evidence.samples == 5
    estimate, on = update(LEARNING, state, 2 * SECOND, 3.0)
    assert on.sensors.evidence.samples <= FIRST + 1  # of the noise, and of the sample of S2 held
    assert math.isfinite(estimate.standard_deviation)
    _, off = update(Parameters(), on, 2 * SECOND + STEP, 3.0)
    assert off.sensors.evidence.samples == 1


def test_s2_alone_does_not_say_how_sure_it_is_while_nothing_is_known() -> None:
    lagging = replace(Parameters(), {"s2.lag_time_constant": 0.5})
    state = initial_state(lagging)
    for k in range(5):
        state = observe_s2(lagging, state, SECOND + k * STEP, float(k))
    assert without_s1(lagging, state, SECOND + 4 * STEP).standard_deviation == 0.0


ROBUST = replace(LEARNING, {"s2.outlier_threshold": 4.0, "s1.bias_time_constant": 0.5})
"""At 100 Hz about 2 % of an innovation is learnt."""


def noisy(size: int) -> list[float]:
    """Return noise of S2 as large as its parameter says."""
    return np.random.default_rng(0).normal(0.0, 0.1, size).tolist()


def test_a_burst_of_garbage_in_s2_corrects_little() -> None:
    burst = np.random.default_rng(1).uniform(-30.0, 90.0, 40).tolist()
    s2 = [*noisy(400), *burst, *noisy(100)]
    errors = {}
    plain = replace(ROBUST, {"s2.outlier_threshold": 0.0})
    for name, parameters in (("plain", plain), ("robust", ROBUST)):
        said, state = fed(parameters, [0.0] * len(s2), s2)
        errors[name] = np.abs(values(said))[400:].max()
    assert errors["robust"] < 0.5
    assert errors["plain"] > 10.0
    assert state.sensors.belief.outliers == 0


def test_an_outlier_of_s2_counts_as_one_at_the_limit() -> None:
    _, state = fed(ROBUST, [0.0] * 400, noisy(400))
    at_ns = 5 * SECOND
    far = observe_s2(ROBUST, state, at_ns, 1e3).sensors
    further = observe_s2(ROBUST, state, at_ns, 1e6).sensors
    assert far.belief.outliers == 1
    assert further.belief.states.bias == pytest.approx(far.belief.states.bias, rel=1e-6)
    assert far.evidence.variance < 1.1 * state.sensors.evidence.variance


@pytest.mark.parametrize("step", [5.0, 500.0])
def test_a_step_of_s2_that_lasts_passes_all_the_same(step: float) -> None:
    s2 = [*noisy(400), *(step + np.array(noisy(600))).tolist()]
    robust, _ = fed(ROBUST, [0.0] * 1000, s2)
    plain, _ = fed(replace(ROBUST, {"s2.outlier_threshold": 0.0}), [0.0] * 1000, s2)
    arrived = [int(np.argmax(np.abs(values(each)) > 0.5 * step)) for each in (robust, plain)]
    assert arrived[0] - arrived[1] <= LASTING
    assert values(robust)[-1] == pytest.approx(step, rel=0.05)


@pytest.mark.parametrize("noise", [0.05, 0.0])
def test_after_a_rest_in_which_s2_repeats_one_number_it_is_not_an_outlier(noise: float) -> None:
    """Innovations of 0 leave nothing of the standard deviation that outliers are told by."""
    changes = {"s1.bias_time_constant": 0.5, "s2.noise": noise, "s2.outlier_threshold": 5.0}
    robust = replace(LEARNING, changes)
    k = np.arange(6000)
    moving = np.where(k < 1000, 0.0, np.sin(0.01 * (k - 1000)))
    bias = np.where(k < 1000, 0.0, 0.5 + 1e-4 * (k - 1000))
    s1, s2 = (moving + bias).round(2).tolist(), moving.round(2).tolist()
    plain, _ = fed(replace(robust, {"s2.outlier_threshold": 0.0}), s1, s2)
    said, state = fed(robust, s1, s2)
    settled = 1000 + (0 if noise else LONGEST) + 200
    error, usual = (
        np.abs(np.array(values(each)) - moving)[settled:].max() for each in (said, plain)
    )
    assert error == pytest.approx(usual, abs=0.01)
    assert error < 0.05
    assert state.sensors.belief.held_back == 0


@pytest.mark.parametrize("quiet", [noisy(400), [0.0] * 1000], ids=["moving", "at rest"])
def test_an_s2_that_grows_noisy_for_good_is_no_longer_an_outlier(quiet: list[float]) -> None:
    loud = (20.0 * np.array(noisy(1000))).tolist()
    s1, s2 = [0.0] * (len(quiet) + len(loud)), [*quiet, *loud]
    _, held = fed(ROBUST, [0.0] * len(quiet), quiet)
    first = observe_s2(ROBUST, held, SECOND + len(quiet) * STEP, 2.0)
    assert first.sensors.belief.outliers == 1
    _, state = fed(ROBUST, s1, s2)
    _, plain = fed(replace(ROBUST, {"s2.outlier_threshold": 0.0}), s1, s2)
    usual = plain.sensors.evidence.variance
    assert state.sensors.evidence.variance == pytest.approx(usual, rel=1e-3)
    assert usual > 1.0


def test_where_s2s_noise_is_unknown_an_s2_that_never_agrees_passes_in_the_end() -> None:
    """It departs faster and faster from what was nearly a rest."""
    away = (1.05 ** np.arange(300)).tolist()
    s2 = [*(1e-3 * np.array(noisy(400))).tolist(), *away]
    robust = replace(ROBUST, {"s2.noise": 0.0})
    _, held = fed(robust, [0.0] * (400 + LONGEST), s2)
    assert held.sensors.belief.held_back == LONGEST
    said, state = fed(robust, [0.0] * len(s2), s2)
    plain, _ = fed(replace(robust, {"s2.outlier_threshold": 0.0}), [0.0] * len(s2), s2)
    assert state.sensors.belief.held_back == 0
    assert values(said)[-1] == pytest.approx(values(plain)[-1], rel=0.1)
