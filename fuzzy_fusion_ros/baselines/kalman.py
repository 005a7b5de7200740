# SPDX-License-Identifier: Apache-2.0
"""Kalman filter over two random walks: the signal and, where it is a state, S1's bias.

S2 measures the signal, S1 the signal plus its bias; no lag is modelled. Each sample is one scalar
correction at its own stamp, so sensors may have any rates and gaps.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.baselines.noise import FINEST
from fuzzy_fusion_ros.baselines.parameters import KalmanParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.numerics import bounded, seconds_between
from fuzzy_fusion_ros.parameters.group import numbers


class Gaussian(NamedTuple):
    """Mean and covariance of the signal and of S1's bias.

    Attributes:
        signal: Mean of the signal.
        bias: Mean of S1's bias.
        p_signal: Variance of the signal.
        p_cross: Covariance of both.
        p_bias: Variance of the bias.
    """

    signal: float
    bias: float
    p_signal: float
    p_cross: float
    p_bias: float


class Kalman(NamedTuple):
    """State of the filter.

    Attributes:
        started: Whether there was a sample of S2, which initialises the signal.
        calibrated: Whether there was a sample of S1 since, which initialises the bias.
        stamp_ns: Stamp of the newest sample.
        belief: Mean and covariance.
    """

    started: bool
    calibrated: bool
    stamp_ns: int
    belief: Gaussian


def kalman(parameters: KalmanParameters) -> Method:
    """Return the method."""
    nothing = Gaussian(signal=0.0, bias=0.0, p_signal=0.0, p_cross=0.0, p_bias=0.0)
    state = Kalman(started=False, calibrated=False, stamp_ns=0, belief=nothing)
    return Method(observe_s2, update, without_s1, numbers(parameters), state)


def observe_s2(parameters: KalmanParameters, state: Kalman, stamp_ns: int, value: float) -> Kalman:
    """Correct by a sample of S2; the first one initialises the signal."""
    variance = parameters.s2_noise * parameters.s2_noise
    if state.started:
        ahead = predict(parameters, state.belief, seconds_between(state.stamp_ns, stamp_ns))
        belief = correct(ahead, 0.0, variance, value)[1]
    else:
        belief = Gaussian(
            signal=bounded(value), bias=0.0, p_signal=variance, p_cross=0.0, p_bias=0.0
        )
    return Kalman(
        started=True,
        calibrated=state.calibrated,
        stamp_ns=max(state.stamp_ns, stamp_ns),
        belief=belief,
    )


def update(
    parameters: KalmanParameters, state: Kalman, stamp_ns: int, value: float
) -> tuple[Estimate, Kalman]:
    """Correct by a sample of S1; the first one initialises the bias, if that is a state."""
    if not state.started:
        return waiting(), state
    variance = parameters.s1_noise * parameters.s1_noise
    belief = predict(parameters, state.belief, seconds_between(state.stamp_ns, stamp_ns))
    gain = 0.0
    if parameters.biased and not state.calibrated:
        belief = Gaussian(
            signal=belief.signal,
            bias=bounded(value - belief.signal),
            p_signal=belief.p_signal,
            p_cross=-belief.p_signal,
            p_bias=belief.p_signal + variance,
        )
    else:
        gain, belief = correct(belief, 1.0, variance, value)
    kept = Kalman(
        started=True,
        calibrated=True,
        stamp_ns=max(state.stamp_ns, stamp_ns),
        belief=belief,
    )
    return estimated(belief.signal, gain, belief.p_signal), kept


def without_s1(parameters: KalmanParameters, state: Kalman, stamp_ns: int) -> Estimate:
    """Estimate at a sample of S2 that has been observed."""
    return estimated(state.belief.signal, 0.0, state.belief.p_signal)


def predict(parameters: KalmanParameters, belief: Gaussian, dt: float) -> Gaussian:
    """Propagate both random walks by ``dt`` seconds; a late sample does not propagate them."""
    elapsed = max(dt, 0.0)
    walked = parameters.process_noise * parameters.process_noise * elapsed
    strayed = parameters.bias_noise * parameters.bias_noise * elapsed
    return Gaussian(
        signal=belief.signal,
        bias=belief.bias,
        p_signal=belief.p_signal + walked,
        p_cross=belief.p_cross,
        p_bias=belief.p_bias + (strayed if parameters.biased else 0.0),
    )


def correct(
    belief: Gaussian, bias_share: float, variance: float, measured: float
) -> tuple[float, Gaussian]:
    """Correct by a measurement of ``signal + bias_share * bias``; covariances in Joseph's form.

    Returns:
        The gain of the signal, and the belief after the measurement.
    """
    h = bias_share
    to_signal = belief.p_signal + h * belief.p_cross
    to_bias = belief.p_cross + h * belief.p_bias
    noise = max(variance, (belief.p_signal + h * belief.p_bias) / (FINEST * FINEST))
    total = max(to_signal + h * to_bias, 0.0) + noise
    k_signal = to_signal / total
    k_bias = to_bias / total
    innovation = bounded(measured - (belief.signal + h * belief.bias))
    a = 1.0 - k_signal
    b = -k_signal * h
    c = -k_bias
    d = 1.0 - k_bias * h
    p, q, r = belief.p_signal, belief.p_cross, belief.p_bias
    return k_signal, Gaussian(
        signal=bounded(belief.signal + k_signal * innovation),
        bias=bounded(belief.bias + k_bias * innovation),
        p_signal=a * a * p + 2.0 * a * b * q + b * b * r + noise * k_signal * k_signal,
        p_cross=a * c * p + (a * d + b * c) * q + b * d * r + noise * k_signal * k_bias,
        p_bias=c * c * p + 2.0 * c * d * q + d * d * r + noise * k_bias * k_bias,
    )
