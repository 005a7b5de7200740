# SPDX-License-Identifier: Apache-2.0
"""The filters that model S2's lag: against matrices, and for what they are meant for."""

from __future__ import annotations

import numpy as np
import pytest
from reference import signals
from reference.lag_filters import MatrixErrorState, MatrixKalmanLag
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.baselines import (
    ErrorStateParameters,
    KalmanLagParameters,
    constant_weight,
    error_state,
    kalman_lag,
)
from fuzzy_fusion_ros.baselines.parameters import ConstantWeightParameters
from fuzzy_fusion_ros.batch.arrays import root_mean_square
from fuzzy_fusion_ros.batch.series import Method, run
from fuzzy_fusion_ros.core.estimator import FUSED
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000

KALMANS = {
    "walk": KalmanLagParameters(),
    "velocity": KalmanLagParameters(
        process_noise=0.0, velocity_deviation=0.5, velocity_time_constant=0.3
    ),
    "one lag": KalmanLagParameters(second_lag_time_constant=0.0, bias_noise=0.0),
    "no lag": KalmanLagParameters(lag_time_constant=0.0, second_lag_time_constant=0.0),
    "quick": KalmanLagParameters(process_noise=10.0, s2_motion_noise=0.0, bias_deviation=0.0),
}
ERROR_STATES = {
    "usual": ErrorStateParameters(),
    "sharp": ErrorStateParameters(s1_noise=0.02, process_noise=0.3),
    "no slopes": ErrorStateParameters(velocity_deviation=0.0, slope_deviation=0.0),
    "no lag": ErrorStateParameters(lag_time_constant=0.0, delay=0.0),
    "short slope": ErrorStateParameters(slope_deviation=1.0, slope_time_constant=0.5),
}
RECORDINGS = {
    "regular": signals.regular(300),
    "irregular": signals.irregular(300, 1, gap_ns=20 * SECOND),
}

KNOWN = KalmanLagParameters(
    process_noise=0.0,
    velocity_deviation=2.0,
    velocity_time_constant=0.5,
    s1_noise=0.05,
    s2_noise=0.005,
    s2_motion_noise=0.01,
    bias_noise=0.01,
    lag_time_constant=0.4,
    second_lag_time_constant=0.01,
)
"""Fits the sensors of ``tuning.recordings``."""

KNOWN_TOO = ErrorStateParameters(
    process_noise=0.1,
    velocity_deviation=2.0,
    velocity_time_constant=0.5,
    s1_noise=0.05,
    lag_time_constant=0.4,
    delay=0.01,
    s2_noise=0.05,
    bias_noise=0.01,
    slope_deviation=0.02,
)


def assert_equal(
    method: Method, judge: MatrixKalmanLag | MatrixErrorState, recording: signals.Recording
) -> None:
    """Compare the estimates of a method with those of its oracle."""
    state, seen = method.state, 0
    found, expected, variances = [], [], []
    for (stamp_ns, value), known in zip(recording.s1, recording.s2_known, strict=True):
        for s2_ns, s2 in recording.s2[seen:known]:
            state = method.observe_s2(method.parameters, state, s2_ns, s2)
            judge.take_s2(s2_ns * 1e-9, s2)
        seen = known
        estimate, state = method.update(method.parameters, state, stamp_ns, value)
        judge.take_s1(stamp_ns * 1e-9, value)
        if seen:
            assert estimate.mode == FUSED
            found.append((estimate.value, estimate.standard_deviation**2))
            expected.append(judge.signal)
            variances.append(judge.variance)
    values, squares = zip(*found, strict=True)
    assert values == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert squares == pytest.approx(variances, rel=1e-4)


@pytest.mark.parametrize("recording", RECORDINGS.values(), ids=RECORDINGS)
@pytest.mark.parametrize("parameters", KALMANS.values(), ids=KALMANS)
def test_the_kalman_filter_is_that_of_matrices(
    parameters: KalmanLagParameters, recording: signals.Recording
) -> None:
    assert_equal(kalman_lag(parameters), MatrixKalmanLag(parameters), recording)


@pytest.mark.parametrize("recording", RECORDINGS.values(), ids=RECORDINGS)
@pytest.mark.parametrize("parameters", ERROR_STATES.values(), ids=ERROR_STATES)
def test_the_error_state_filter_is_that_of_matrices(
    parameters: ErrorStateParameters, recording: signals.Recording
) -> None:
    assert_equal(error_state(parameters), MatrixErrorState(parameters), recording)


@pytest.mark.parametrize("method", [kalman_lag(KNOWN), error_state(KNOWN_TOO)])
@pytest.mark.parametrize("spikes", [0.0, 0.1])
def test_they_see_through_lag_bias_and_spikes(method: Method, spikes: float) -> None:
    series, truth = made(Sensors(spikes=spikes), seconds=60.0)
    settled = np.arange(truth.size) > truth.size // 6

    def rmse(each: Method) -> float:
        return root_mean_square((run(each, series).value - truth)[settled])

    sensors = [rmse(constant_weight(ConstantWeightParameters(weight))) for weight in (0.0, 1.0)]
    assert rmse(method) < 0.25 * min(sensors)


def test_a_constant_drift_is_carried_through_a_gap_of_s2() -> None:
    series, truth = made(Sensors(drift=0.05, noise=0.005, gap=(25.0, 39.0)), seconds=40.0)
    with_slope = run(error_state(KNOWN_TOO), series).value
    without = replace(KNOWN_TOO, {"slope_deviation": 0.0})
    gap = slice(-250, -50)
    drifted = root_mean_square((run(error_state(without), series).value - truth)[gap])
    assert root_mean_square((with_slope - truth)[gap]) < 0.3 * drifted


def test_variances_never_fall_below_zero() -> None:
    parameters = KalmanLagParameters(
        process_noise=1e-9, s1_noise=1e-12, s2_noise=1e-12, bias_noise=1e9
    )
    method = kalman_lag(parameters)
    state = method.state
    for k in range(200):
        stamp_ns = SECOND + k * 10_000_000
        state = method.observe_s2(method.parameters, state, stamp_ns, float(k % 3))
        estimate, state = method.update(method.parameters, state, stamp_ns, float(k % 5))
        p = state.belief.covariance
        assert np.isfinite(estimate.value)
        assert min(p.ss, p.vv, p.bb, p.ff, p.gg) >= 0.0


def test_a_sample_that_comes_late_is_taken_as_of_now() -> None:
    for method in (kalman_lag(KNOWN), error_state(KNOWN_TOO)):
        state = method.observe_s2(method.parameters, method.state, 2 * SECOND, 0.0)
        _, state = method.update(method.parameters, state, 2 * SECOND, 0.0)
        late = method.observe_s2(method.parameters, state, SECOND, 0.0)
        estimate, _ = method.update(method.parameters, late, 3 * SECOND, 0.0)
        assert estimate.value == 0.0
