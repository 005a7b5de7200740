# SPDX-License-Identifier: Apache-2.0
"""Parameters of the baselines as one would choose them by hand from the recording."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines.parameters import (
    BaselineParameters,
    ComplementaryParameters,
    ErrorStateParameters,
    KalmanLagParameters,
    KalmanParameters,
)
from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square, white_noise
from fuzzy_fusion_ros.batch.bursts import bursts_of
from fuzzy_fusion_ros.batch.cleaning import without_noise, without_spikes
from fuzzy_fusion_ros.batch.lag import TRUSTED, Lag, lag_of, read_through
from fuzzy_fusion_ros.batch.series import Series, seconds

_FEWEST = 8
"""With fewer samples of either sensor, nothing is derived."""
_TINY = 1e-9
_LARGE = 1e9


class _Shown(NamedTuple):
    """What a recording shows; seconds, and the unit of the signal.

    Attributes:
        span: Length of the recording.
        s1_interval: Mean time between samples of S1.
        period: Mean time between samples of S2.
        lag: Of S2 behind S1, none where the recording does not show it.
        s1_noise: Standard deviation of S1's white noise.
        s2_noise: Standard deviation of S2's, which includes some of its motion.
        step: Mean square of the steps of S2.
        rate: Root mean square of dS2/dt.
        apart: Root mean square of S1 minus S2.
        error: Root mean square of S1, seen through the lag, minus S2.
        wander: Standard deviation of that difference.
    """

    span: float
    s1_interval: float
    period: float
    lag: Lag
    s1_noise: float
    s2_noise: float
    step: float
    rate: float
    apart: float
    error: float
    wander: float


def baselines_for(series: Series) -> BaselineParameters:
    """Derive parameters from the noise, motion and lag in a recording, without fitting.

    Args:
        series: The recording; a very short one gives the defaults.
    """
    if min(series.s1.size, series.s2.size) < _FEWEST:
        return BaselineParameters()
    shown = _shown(series)
    lag, period = shown.lag.total, shown.period
    walked = max(shown.step - 2.0 * shown.s2_noise**2, 0.01 * shown.step, _TINY**2)
    stale = _allowed(math.sqrt(walked * (lag + 0.5 * period) / period + shown.s2_noise**2))
    walk = _allowed(math.sqrt(walked / period))
    inaccuracy = max(shown.apart, shown.s1_noise)
    bias_noise = _allowed(inaccuracy / shown.span**0.5)
    s2_lags = lag > 0.5 * period + 2.0 * shown.s1_interval
    slow = lag + 0.5 * period if s2_lags else 10.0 * period
    s1_noise = _allowed(shown.s1_noise)
    return BaselineParameters(
        complementary=ComplementaryParameters(slow, 0.0, s2_lags),
        complementary_lowpass=ComplementaryParameters(slow, 0.1 * slow, s2_lags),
        kalman=KalmanParameters(walk, _allowed(inaccuracy), stale),
        kalman_bias=KalmanParameters(walk, s1_noise, stale, True, bias_noise),
        kalman_lag=_kalman_lag(shown, walk, 0.0),
        kalman_lag_cv=_kalman_lag(shown, 0.0, _allowed(3.0 * shown.rate)),
        error_state=_error_state(shown),
    )


def _kalman_lag(shown: _Shown, process_noise: float, velocity: float) -> KalmanLagParameters:
    late = max(shown.lag.total, shown.period)
    shortest = 0.1 * shown.period
    return KalmanLagParameters(
        process_noise=process_noise,
        velocity_deviation=velocity,
        velocity_time_constant=late if velocity > 0.0 else 0.0,
        s1_noise=_allowed(shown.s1_noise),
        s2_noise=_allowed(0.05 * shown.rate * shown.period),
        s2_motion_noise=0.03 * late,
        bias_deviation=_allowed(shown.error),
        bias_noise=_allowed(shown.wander / shown.span**0.5),
        lag_time_constant=max(shown.lag.time_constant, shortest),
        second_lag_time_constant=max(shown.lag.delay, shortest),
    )


def _error_state(shown: _Shown) -> ErrorStateParameters:
    late = max(shown.lag.total, shown.period)
    shortest = 0.1 * shown.period
    return ErrorStateParameters(
        process_noise=_allowed(shown.rate * late**0.5),
        velocity_deviation=_allowed(3.0 * shown.rate),
        velocity_time_constant=late,
        s1_noise=_allowed(shown.s1_noise),
        lag_time_constant=max(shown.lag.time_constant, shortest),
        delay=max(shown.lag.delay, shortest),
        s2_noise=_allowed(0.05 * shown.rate * shown.period),
        s2_motion_noise=0.03 * late,
        bias_deviation=_allowed(shown.error),
        bias_noise=_allowed(shown.wander / shown.span**0.5),
        slope_deviation=_allowed(shown.wander / shown.span),
        slope_time_constant=shown.span,
    )


def _shown(series: Series) -> _Shown:
    s1_s, s2_s = seconds(series)
    span = float(s2_s[-1] - s2_s[0])
    period = span / (series.s2.size - 1)
    s1 = without_spikes(series.s1)[0]
    clean = without_noise(s1_s, s1, bursts_of(s2_s).interval)
    lag = lag_of(s1_s, clean, s2_s, series.s2)
    if lag.correlation < TRUSTED:
        lag = Lag(0.0, 0.0, lag.correlation)
    steps = np.diff(series.s2)
    error = read_through(lag, s1_s, s1, s2_s) - series.s2
    return _Shown(
        span=span,
        s1_interval=float(s1_s[-1]) / (series.s1.size - 1),
        period=period,
        lag=lag,
        s1_noise=_noise_of(series.s1),
        s2_noise=_noise_of(series.s2),
        step=float(np.mean(np.square(steps))),
        rate=root_mean_square(steps / np.diff(s2_s)),
        apart=root_mean_square(series.s1 - np.interp(s1_s, s2_s, series.s2)),
        error=root_mean_square(error),
        wander=float(np.std(error)),
    )


def _noise_of(values: Reals) -> float:
    """Return the white noise in a series; never 0."""
    return max(white_noise(values), 1e-3 * float(np.std(values)), _TINY)


def _allowed(number: float) -> float:
    """Return a number within what the parameters allow, more than 0."""
    return min(max(number, _TINY), _LARGE)
