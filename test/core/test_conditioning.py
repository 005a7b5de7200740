"""S1 before the aggregator: spikes, low-pass, bias."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.aggregator import SlowSensor, no_slow_sensor
from fuzzy_fusion_ros.core.conditioning import (
    LONGEST_SPIKE,
    NO_BIAS,
    Bias,
    Conditioned,
    bias_at,
    condition,
    learn_bias,
    unconditioned,
)
from fuzzy_fusion_ros.parameters.fusion import (
    BreakPoints,
    FastSensorParameters,
    SlowSensorParameters,
)

SECOND = 1_000_000_000
STEP = 10_000_000
RAMP = BreakPoints(0.0, 1.0)
NO_MODEL = SlowSensorParameters()


def conditioned(
    parameters: FastSensorParameters,
    s1: list[float],
    s2: list[float] | None = None,
    rate: float = 0.0,
    model: SlowSensorParameters = NO_MODEL,
    step_ns: int = STEP,
) -> list[Conditioned]:
    """Feed samples of S1, each after one of S2 if there are any, and return what is kept."""
    kept = unconditioned()
    said = []
    for k, value in enumerate(s1):
        stamp_ns = SECOND + k * step_ns
        slow = no_slow_sensor()
        if s2 is not None:
            slow = SlowSensor(k + 1, stamp_ns, s2[k], rate)
        kept = condition(parameters, model, RAMP, kept, slow, stamp_ns, value)
        said.append(kept)
    return said


def values(said: list[Conditioned]) -> list[float]:
    """Return the conditioned values."""
    return [each.value for each in said]


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=20))
def test_by_default_s1_passes_bit_for_bit(s1: list[float]) -> None:
    said = conditioned(FastSensorParameters(), s1, [0.0] * len(s1))
    assert np.array(values(said)).tobytes() == np.array(s1).tobytes()


def test_samples_are_counted_with_their_stamps() -> None:
    """None are while all steps are off, so that conditioning starts anew when one is on."""
    for parameters, counts in (
        (FastSensorParameters(), (0, 0)),
        (FastSensorParameters(lowpass_time_constant=0.1), (1, 2)),
    ):
        said = conditioned(parameters, [0.1, 0.2])
        assert [(each.samples, each.stamp_ns) for each in said] == [
            (counts[0], SECOND),
            (counts[1], SECOND + STEP),
        ]


@pytest.mark.parametrize(
    ("s1", "passed"),
    [
        ([0.0, 9.0, 0.25], [0.0, 0.0, 0.25]),
        ([0.0, -9.0, 0.25], [0.0, 0.0, 0.25]),
        ([0.0, 0.5, 0.75], [0.0, 0.5, 0.75]),  # as far as the threshold is none
        ([9.0, 0.0, 9.25], [9.0, 9.0, 9.25]),  # the first is taken whatever it is,
        ([9.0, 0.0, 0.0], [9.0, 9.0, 0.0]),  # and soon given up
        ([0.0, 0.0, 9.0, -9.0, 0.25], [0.0, 0.0, 0.0, 0.0, 0.25]),
        ([0.0, 9.0, 0.0, 9.0, 0.0, 9.0, 0.0], [0.0] * 7),
        ([0.0] * 20 + [9.0] * LONGEST_SPIKE + [0.0], [0.0] * (LONGEST_SPIKE + 21)),
        ([0.0] * 20 + [9.0] * (LONGEST_SPIKE + 2), [0.0] * (LONGEST_SPIKE + 20) + [9.0] * 2),
        ([0.0] * 5 + [9.0] * 6 + [0.0] * 2, [0.0] * 10 + [9.0, 0.0, 0.0]),  # taken for a moment
        ([0.0] * 9 + [0.5, -0.25], [0.0] * 9 + [0.5, -0.25]),  # a small one locks none out
        ([10.0 * k for k in range(5)], [0.0, 0.0, 20.0, 30.0, 40.0]),  # steeper than that: all
    ],
)
def test_a_spike_is_left_out(s1: list[float], passed: list[float]) -> None:
    assert values(conditioned(FastSensorParameters(spike_threshold=0.5), s1)) == passed


def test_a_spike_does_not_enter_the_model_of_s2() -> None:
    """So it does not matter there how high it is."""
    parameters = FastSensorParameters(spike_threshold=0.5, bias_time_constant=1.0)
    model = SlowSensorParameters(lag_time_constant=0.1)

    def lagged(spike: float) -> list[float]:
        said = conditioned(parameters, [1.0, 1.0, spike, 1.0], [0.0] * 4, model=model)
        return [each.lagged for each in said]

    assert lagged(9.0) == lagged(-90.0) == pytest.approx([1.0] * 4)


def test_a_spike_does_not_stop_a_trend() -> None:
    ramp = [0.01 * k for k in range(500)]
    parameters = FastSensorParameters(
        spike_threshold=0.5, lowpass_time_constant=0.1, trend_time_constant=0.2
    )
    said = values(conditioned(parameters, [*ramp[:-1], 9.0]))
    assert said[-1] == pytest.approx(ramp[-1], abs=1e-9)


def test_the_low_pass_goes_its_way_to_a_step() -> None:
    said = conditioned(FastSensorParameters(lowpass_time_constant=0.1), [0.0] + [1.0] * 10)
    assert values(said)[-1] == pytest.approx(1.0 - math.exp(-1.0))


def test_a_ramp_lags_behind_by_the_time_constant_unless_there_is_a_trend() -> None:
    ramp = [0.01 * k for k in range(500)]
    plain = FastSensorParameters(lowpass_time_constant=0.1)
    trend = FastSensorParameters(lowpass_time_constant=0.1, trend_time_constant=0.2)
    assert ramp[-1] - values(conditioned(plain, ramp))[-1] == pytest.approx(0.1, abs=0.01)
    assert values(conditioned(trend, ramp))[-1] == pytest.approx(ramp[-1], abs=1e-9)


@pytest.mark.parametrize("trend", [0.0, 0.2])
def test_a_low_pass_quiets_noise(trend: float) -> None:
    noise = np.random.default_rng(0).normal(0.0, 1.0, 3000).tolist()
    smooth = FastSensorParameters(lowpass_time_constant=0.2, trend_time_constant=trend)
    assert np.std(values(conditioned(smooth, noise))[500:]) < 0.4


@pytest.mark.parametrize(("gap_ns", "value"), [(SECOND, 1.0 - math.exp(-1.0)), (SECOND + 1, 1.0)])
def test_a_gap_restarts_the_low_pass(gap_ns: int, value: float) -> None:
    parameters = FastSensorParameters(lowpass_time_constant=1.0, timeout=1.0)
    said = conditioned(parameters, [0.0, 1.0], step_ns=gap_ns)
    assert values(said) == pytest.approx([0.0, value])


def test_a_gap_restarts_the_model_of_s2() -> None:
    """What S1 was before the gap is not what a late S2 reads after it."""
    parameters = FastSensorParameters(bias_time_constant=1.0, timeout=1.0)
    model = SlowSensorParameters(delay=0.5)
    kept = conditioned(parameters, [100.0] * 100, model=model)[-1]
    stamp_ns = kept.stamp_ns + 2 * SECOND
    first = SlowSensor(1, stamp_ns, 0.0, 0.0)
    kept = condition(parameters, model, RAMP, kept, first, stamp_ns, 0.25)
    assert kept.line.filled == 1
    assert kept.bias.value == 0.25


def test_a_gap_keeps_the_bias() -> None:
    parameters = FastSensorParameters(bias_time_constant=1.0, timeout=1.0)
    kept = conditioned(parameters, [0.5] * 300, [0.0] * 300)[-1]
    late_ns = kept.stamp_ns + 60 * SECOND
    held = SlowSensor(300, kept.stamp_ns, 0.0, 0.0)
    assert kept.bias.value == pytest.approx(0.5)
    after = condition(parameters, NO_MODEL, RAMP, kept, held, late_ns, 0.7)
    assert after.value == pytest.approx(0.2)


@pytest.mark.parametrize("samples", [1, 2, 10, 1000])
def test_a_constant_bias_is_known_from_the_first_sample_on(samples: int) -> None:
    parameters = FastSensorParameters(bias_time_constant=10.0)
    said = conditioned(parameters, [0.5] * samples, [0.2] * samples)
    assert said[-1].bias.value == pytest.approx(0.3)
    assert values(said) == pytest.approx([0.2] * samples)


def test_noise_is_averaged_out_of_the_bias() -> None:
    noise = np.random.default_rng(1).normal(0.3, 0.1, 3000).tolist()
    parameters = FastSensorParameters(bias_time_constant=100.0)
    said = conditioned(parameters, noise, [0.0] * 3000)
    assert said[-1].bias.value == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize("rate", [1.0, -1.0, 50.0])
def test_in_motion_the_bias_is_not_learnt(rate: float) -> None:
    parameters = FastSensorParameters(bias_time_constant=1.0)
    still = conditioned(parameters, [0.3] * 300, [0.0] * 300)[-1]
    kept = still
    for k in range(1, 300):
        stamp_ns = still.stamp_ns + k * STEP
        s2 = SlowSensor(300 + k, stamp_ns, 5.0, rate)
        kept = condition(parameters, NO_MODEL, RAMP, kept, s2, stamp_ns, 0.3)
    assert kept.bias.value == still.bias.value


def test_a_share_of_the_learning_may_go_on_in_motion() -> None:
    def learnt(share: float, rate: float) -> float:
        parameters = FastSensorParameters(bias_time_constant=1.0, bias_moving_share=share)
        s1 = [0.0] * 1200 + [0.3] * 100
        return conditioned(parameters, s1, [0.0] * 1300, rate)[-1].bias.value

    assert learnt(1.0, 5.0) == pytest.approx(learnt(0.0, 0.0))
    assert learnt(0.5, 0.0) == pytest.approx(learnt(0.0, 0.0))
    assert 0.0 < learnt(0.1, 5.0) < learnt(0.5, 5.0) < learnt(1.0, 5.0)


def test_a_drifting_bias_is_followed_along_its_slope() -> None:
    s1 = [0.001 * k for k in range(6000)]  # 0.1 a second
    plain = FastSensorParameters(bias_time_constant=2.0)
    drift = FastSensorParameters(bias_time_constant=2.0, drift_time_constant=5.0)
    lag = values(conditioned(plain, s1, [0.0] * 6000))[-1]
    followed = conditioned(drift, s1, [0.0] * 6000)[-1]
    assert lag == pytest.approx(0.2, rel=0.05)
    assert followed.value == pytest.approx(0.0, abs=0.01)
    assert followed.bias.slope == pytest.approx(0.1, rel=0.05)


def taught(parameters: FastSensorParameters, kept: Bias, at_s: list[float], e: list[float]) -> Bias:
    """Return the bias after errors at some times, the signal being quiet."""
    for time_s, error in zip(at_s, e, strict=True):
        kept = learn_bias(parameters, kept, SECOND + round(time_s * SECOND), error, 1.0)
    return kept


def test_after_a_gap_a_mean_begins_again() -> None:
    parameters = FastSensorParameters(bias_time_constant=5.0)
    before = taught(parameters, NO_BIAS, [0.1 * k for k in range(200)], [0.0] * 200)
    times = [60.0 + 0.1 * k for k in range(20)]
    first = taught(parameters, before, times[:1], [1.5])
    after = taught(parameters, before, times, [1.5, 0.5] * 10)
    assert 0.5 < first.value < 1.0  # not all of the gap's time speaks for one error
    assert after.value == pytest.approx(1.0, abs=0.1)
    assert after.interval == pytest.approx(0.1)


def test_in_a_gap_no_more_than_the_time_constant_fades() -> None:
    """However long the bias was learnt before."""
    parameters = FastSensorParameters(bias_time_constant=5.0)
    before = taught(parameters, NO_BIAS, [0.1 * k for k in range(200)], [0.0] * 200)
    assert before.learnt == pytest.approx(19.9)
    after = taught(parameters, before, [29.9], [1.0])
    assert after.learnt == pytest.approx(5.0 * math.exp(-9.9 / 5.0) + 0.1)


def test_a_short_gap_is_none_and_fades_nothing() -> None:
    parameters = FastSensorParameters(bias_time_constant=5.0)
    before = taught(parameters, NO_BIAS, [0.1 * k for k in range(200)], [0.0] * 200)
    late = taught(parameters, before, [20.1], [1.0])
    assert late.value == pytest.approx(1.0 - math.exp(-0.2 / 5.0))
    assert late.learnt == pytest.approx(before.learnt + 0.2)


def test_a_slope_is_believed_for_as_long_as_it_was_learnt_over() -> None:
    bias = Bias(samples=9, stamp_ns=SECOND, interval=0.1, value=0.5, slope=0.1, learnt=1.0)
    damped = FastSensorParameters(drift_time_constant=20.0)
    assert bias_at(damped, bias, SECOND) == 0.5
    assert bias_at(damped, bias, 2 * SECOND) == pytest.approx(0.6, abs=0.003)
    assert bias_at(damped, bias, 21 * SECOND) == pytest.approx(0.5 + 2.0 * (1.0 - math.exp(-1.0)))
    assert bias_at(damped, bias, 10_000 * SECOND) == pytest.approx(2.5)
    assert bias_at(damped, bias, 0) == pytest.approx(0.4, abs=0.003)
    assert bias_at(damped, bias, -(2**62)) == pytest.approx(-1.5)
    assert bias_at(damped, NO_BIAS, 10_000 * SECOND) == 0.0


def test_each_sample_of_s2_teaches_once() -> None:
    parameters = FastSensorParameters(bias_time_constant=1.0)
    kept = unconditioned()
    held = SlowSensor(1, SECOND, 0.0, 0.0)
    for k in range(5):
        kept = condition(parameters, NO_MODEL, RAMP, kept, held, SECOND + k * STEP, 0.1 * k)
    assert (kept.bias.samples, kept.bias.value) == (1, 0.0)


def test_without_s2_there_is_no_bias() -> None:
    said = conditioned(FastSensorParameters(bias_time_constant=1.0), [0.5] * 10)
    assert values(said) == [0.5] * 10


@pytest.mark.parametrize(
    ("lag", "delay"), [(0.3, 0.0), (0.0, 0.2), (0.3, 0.2)], ids=["lag", "delay", "both"]
)
def test_the_model_of_s2_keeps_motion_out_of_the_bias(lag: float, delay: float) -> None:
    """On a ramp a slow S2 differs from S1 by its slowness; with the model that is no bias."""
    t = np.arange(2000) * 0.01
    truth = 0.5 * t
    behind = np.maximum(t - delay, 0.0)
    s2 = 0.5 * (behind - lag * (1.0 - np.exp(-behind / max(lag, 1e-9))))
    s1 = (truth + 0.3).tolist()
    learning = FastSensorParameters(bias_time_constant=2.0, bias_moving_share=1.0)

    def bias(model: SlowSensorParameters) -> float:
        return conditioned(learning, s1, s2.tolist(), 0.5, model)[-1].bias.value

    fitting = SlowSensorParameters(lag_time_constant=lag, delay=delay)
    assert bias(NO_MODEL) == pytest.approx(0.3 + 0.5 * (lag + delay), abs=0.01)
    assert bias(fitting) == pytest.approx(0.3, abs=0.01)


EVERYTHING = FastSensorParameters(
    spike_threshold=1.0,
    lowpass_time_constant=0.05,
    trend_time_constant=0.2,
    bias_time_constant=1.0,
    bias_moving_share=0.1,
    drift_time_constant=5.0,
)
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(
    st.lists(st.tuples(FINITE, FINITE), min_size=1, max_size=25),
    st.sampled_from([1, 1000, STEP, SECOND]),
    st.sampled_from([0.0, 0.1]),
)
@example([(1.7e308, -1.7e308), (-1.7e308, 1.7e308)] * 8, 1, 0.1)
@example([(1.7e308, -1.7e308), (-1.7e308, 1.7e308)] * 8, STEP, 0.0)
def test_what_is_finite_stays_finite(
    samples: list[tuple[float, float]], step_ns: int, slowness: float
) -> None:
    model = SlowSensorParameters(lag_time_constant=slowness, delay=slowness)
    s1, s2 = [a for a, _ in samples], [b for _, b in samples]
    for parameters in (
        EVERYTHING,
        FastSensorParameters(lowpass_time_constant=0.1),
        FastSensorParameters(bias_time_constant=0.1),
    ):
        said = conditioned(parameters, s1, s2, 0.0, model, step_ns)
        assert all(math.isfinite(value) for value in values(said))
