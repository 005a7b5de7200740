# SPDX-License-Identifier: Apache-2.0
"""Error-state filter: S1 propagates the signal, a Kalman filter learns S1's bias.

S1, low-passed with a trend, is the signal plus the bias. The bias is measured by what S2 would read
if S1 were right, S1 through S2's lag and delay, minus what S2 reads. Outliers of either sensor
count little.

Its variance is the sum of those of the low-passed S1 and of the bias, as if their errors were
independent. They are not, since the bias is learnt from that S1: the variance is approximate.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.baselines.noise import variance_in_motion
from fuzzy_fusion_ros.baselines.parameters import ErrorStateParameters
from fuzzy_fusion_ros.baselines.trend import MotionModel, Trend, corrected, first_trend, propagated
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.delay_line import DelayLine, delayed, empty_line, extended
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.parameters.group import numbers


class ErrorState(NamedTuple):
    """State of the filter.

    Attributes:
        s1_samples: Samples of S1 so far.
        s1_ns: Stamp of the last of them.
        s1: S1, low-passed.
        lagged: That after the lag of S2.
        line: The recent past of ``lagged``.
        s2_samples: Samples of S2 so far.
        s2_ns: Stamp of the last of them.
        s2: That sample.
        bias_ns: Stamp to which the bias is propagated.
        bias: Bias of S1.
    """

    s1_samples: int
    s1_ns: int
    s1: Trend
    lagged: float
    line: DelayLine
    s2_samples: int
    s2_ns: int
    s2: float
    bias_ns: int
    bias: Trend


def error_state(parameters: ErrorStateParameters) -> Method:
    """Return the method."""
    plain = numbers(parameters)
    state = ErrorState(
        s1_samples=0,
        s1_ns=0,
        s1=first_trend(motion_of_s1(plain), 0.0, plain.s1_noise),
        lagged=0.0,
        line=empty_line(),
        s2_samples=0,
        s2_ns=0,
        s2=0.0,
        bias_ns=0,
        bias=first_trend(motion_of_bias(plain), 0.0, plain.bias_deviation),
    )
    return Method(observe_s2, update, without_s1, plain, state)


def observe_s2(
    parameters: ErrorStateParameters, state: ErrorState, stamp_ns: int, value: float
) -> ErrorState:
    """Correct the bias by a sample of S2."""
    s2 = bounded(value)
    bias_ns = state.bias_ns
    bias = state.bias
    if state.s1_samples > 0:
        since = seconds_between(state.s2_ns, stamp_ns)
        rate = bounded((s2 - state.s2) / since) if state.s2_samples > 0 and since > 0.0 else 0.0
        variance = variance_in_motion(parameters.s2_noise, parameters.s2_motion_noise, rate)
        seen = delayed(state.line, state.s1_ns, state.lagged, stamp_ns, parameters.delay)
        bias = propagated(motion_of_bias(parameters), bias, seconds_between(bias_ns, stamp_ns))
        bias = corrected(bias, seen - s2, variance)
        bias_ns = max(bias_ns, stamp_ns)
    return ErrorState(
        s1_samples=state.s1_samples,
        s1_ns=state.s1_ns,
        s1=state.s1,
        lagged=state.lagged,
        line=state.line,
        s2_samples=state.s2_samples + 1,
        s2_ns=stamp_ns,
        s2=s2,
        bias_ns=bias_ns,
        bias=bias,
    )


def update(
    parameters: ErrorStateParameters, state: ErrorState, stamp_ns: int, value: float
) -> tuple[Estimate, ErrorState]:
    """Propagate the signal by a sample of S1 and estimate."""
    value = bounded(value)
    if state.s1_samples > 0:
        dt = seconds_between(state.s1_ns, stamp_ns)
        ahead = propagated(motion_of_s1(parameters), state.s1, dt)
        s1 = corrected(ahead, value, parameters.s1_noise * parameters.s1_noise)
        share = lag_gain(dt, parameters.lag_time_constant)
        lagged = state.lagged + share * (s1.x - state.lagged)
        since = seconds_between(state.bias_ns, stamp_ns)
        bias = propagated(motion_of_bias(parameters), state.bias, since)
    else:
        s1 = first_trend(motion_of_s1(parameters), value, parameters.s1_noise)
        lagged = value
        bias = state.bias
        if state.s2_samples > 0:
            bias = corrected(bias, value - state.s2, parameters.s2_noise * parameters.s2_noise)
    kept = ErrorState(
        s1_samples=state.s1_samples + 1,
        s1_ns=stamp_ns,
        s1=s1,
        lagged=lagged,
        line=extended(state.line, stamp_ns, lagged, parameters.delay),
        s2_samples=state.s2_samples,
        s2_ns=state.s2_ns,
        s2=state.s2,
        bias_ns=max(state.bias_ns, stamp_ns),
        bias=bias,
    )
    if state.s2_samples == 0:
        return waiting(), kept
    return estimated(bounded(s1.x - bias.x), 1.0, s1.xx + bias.xx), kept


def without_s1(parameters: ErrorStateParameters, state: ErrorState, stamp_ns: int) -> Estimate:
    """Estimate at a sample of S2 that has been observed: nothing propagates the signal."""
    return estimated(state.s2, 0.0)


def motion_of_s1(parameters: ErrorStateParameters) -> MotionModel:
    """Return how S1 moves."""
    return MotionModel(
        parameters.process_noise, parameters.velocity_deviation, parameters.velocity_time_constant
    )


def motion_of_bias(parameters: ErrorStateParameters) -> MotionModel:
    """Return how S1's bias moves."""
    return MotionModel(
        parameters.bias_noise, parameters.slope_deviation, parameters.slope_time_constant
    )
