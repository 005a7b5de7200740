# SPDX-License-Identifier: Apache-2.0
"""The Kalman filters, against filterpy's."""

from __future__ import annotations

import numpy as np
import pytest
from reference import signals
from reference.kalman import RandomWalks

from fuzzy_fusion_ros.baselines import KalmanParameters, kalman
from fuzzy_fusion_ros.core.estimator import FUSED

SECOND = 1_000_000_000

VARIANTS = {
    "signal": KalmanParameters(0.3, 0.05, 0.02),
    "quick": KalmanParameters(10.0, 0.05, 0.02),
    "slow": KalmanParameters(1e-3, 1.0, 0.5),
    "bias": KalmanParameters(0.3, 0.05, 0.02, biased=True, bias_noise=0.01),
    "constant bias": KalmanParameters(0.3, 0.05, 0.02, biased=True, bias_noise=0.0),
    "wild bias": KalmanParameters(0.1, 0.05, 0.02, biased=True, bias_noise=5.0),
}


@pytest.mark.parametrize("name", VARIANTS)
@pytest.mark.parametrize(
    "recording", [signals.regular(300), signals.irregular(300, 1, gap_ns=20 * SECOND)]
)
def test_it_is_filterpys(name: str, recording: signals.Recording) -> None:
    parameters = VARIANTS[name]
    method = kalman(parameters)
    judge = RandomWalks(
        parameters.process_noise,
        parameters.s1_noise,
        parameters.s2_noise,
        parameters.bias_noise if parameters.biased else None,
    )
    state, seen = method.state, 0
    found, expected, variances = [], [], []
    for (stamp_ns, value), known in zip(recording.s1, recording.s2_known, strict=True):
        for s2_ns, s2 in recording.s2[seen:known]:
            state = method.observe_s2(method.parameters, state, s2_ns, s2)
            judge.take_s2(s2_ns * 1e-9, s2)
        seen = known
        estimate, state = method.update(method.parameters, state, stamp_ns, value)
        if seen:
            judge.take_s1(stamp_ns * 1e-9, value)
            assert estimate.mode == FUSED
            found.append((estimate.value, estimate.standard_deviation**2))
            expected.append(judge.signal)
            variances.append(judge.variance)
    values, squares = zip(*found, strict=True)
    assert values == pytest.approx(expected, rel=1e-6, abs=1e-6)
    assert squares == pytest.approx(variances, rel=1e-4)


def test_a_constant_bias_is_found() -> None:
    generator = np.random.default_rng(0)
    parameters = KalmanParameters(0.1, 0.05, 0.02, biased=True, bias_noise=0.001)
    method = kalman(parameters)
    state = method.state
    for k in range(3000):
        stamp_ns = SECOND + k * 10_000_000
        state = method.observe_s2(method.parameters, state, stamp_ns, generator.normal(0.0, 0.02))
        _, state = method.update(
            method.parameters, state, stamp_ns, 0.7 + generator.normal(0.0, 0.05)
        )
    assert state.belief.bias == pytest.approx(0.7, abs=0.01)
    assert state.belief.signal == pytest.approx(0.0, abs=0.02)


def test_a_sample_that_comes_late_is_taken_as_of_now() -> None:
    method = kalman(KalmanParameters(1.0, 0.1, 0.1))
    state = method.observe_s2(method.parameters, method.state, 2 * SECOND, 0.0)
    state = method.observe_s2(method.parameters, state, SECOND, 1.0)
    assert (state.stamp_ns, state.belief.signal) == (2 * SECOND, 0.5)


def test_variances_never_fall_below_zero() -> None:
    method = kalman(KalmanParameters(1e-9, 1e-12, 1e-12, biased=True, bias_noise=1e9))
    state = method.state
    for k in range(200):
        stamp_ns = SECOND + k * 10_000_000
        state = method.observe_s2(method.parameters, state, stamp_ns, float(k % 3))
        estimate, state = method.update(method.parameters, state, stamp_ns, float(k % 5))
        assert np.isfinite(estimate.value)
        assert min(state.belief.p_signal, state.belief.p_bias) >= 0.0
