"""Parameters of the baselines as one would set them by hand after looking at the recording."""

from __future__ import annotations

import math

import numpy as np

from fuzzy_fusion_ros.baselines.parameters import (
    BaselineParameters,
    ComplementaryParameters,
    KalmanParameters,
)
from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square, white_noise
from fuzzy_fusion_ros.batch.cleaning import without_noise, without_spikes
from fuzzy_fusion_ros.batch.lag import TRUSTED, Lag, lag_of
from fuzzy_fusion_ros.batch.series import Series, seconds

_FEWEST = 8
"""With fewer samples of either sensor, nothing is derived."""
_TINY = 1e-9


def baselines_for(series: Series) -> BaselineParameters:
    """Derive parameters from the noise, motion and lag in a recording, without fitting.

    Args:
        series: The recording; a very short one gives the defaults.
    """
    if min(series.s1.size, series.s2.size) < _FEWEST:
        return BaselineParameters()
    s1_s, s2_s = seconds(series)
    span = float(s2_s[-1] - s2_s[0])
    period = span / (series.s2.size - 1)
    lag = _trusted_lag(s1_s, series.s1, s2_s, series.s2).total
    s1_noise = _noise_of(series.s1)
    s2_noise = _noise_of(series.s2)
    apart = series.s1 - np.interp(series.s1_ns, series.s2_ns, series.s2)
    steps = float(np.mean(np.square(np.diff(series.s2))))
    walked = max(steps - 2.0 * s2_noise**2, 0.01 * steps, _TINY**2)
    process_noise = math.sqrt(walked / period)
    stale = math.sqrt(walked * (lag + 0.5 * period) / period + s2_noise**2)
    inaccuracy = max(root_mean_square(apart), s1_noise)
    s2_lags = lag > 0.5 * period + 2.0 * span / series.s1.size
    slow = lag + 0.5 * period if s2_lags else 10.0 * period
    noises = map(_allowed, (process_noise, inaccuracy, s1_noise, stale, inaccuracy / span**0.5))
    process_noise, inaccuracy, s1_noise, stale, bias_noise = noises
    return BaselineParameters(
        complementary=ComplementaryParameters(slow, 0.0, s2_lags),
        complementary_lowpass=ComplementaryParameters(slow, 0.1 * slow, s2_lags),
        kalman=KalmanParameters(process_noise, inaccuracy, stale),
        kalman_bias=KalmanParameters(process_noise, s1_noise, stale, True, bias_noise),
    )


def _trusted_lag(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals) -> Lag:
    """Return S2's lag behind S1, none where the recording does not show it."""
    interval = float(np.median(np.diff(s2_s)))
    clean = without_noise(s1_s, without_spikes(s1)[0], interval)
    lag = lag_of(s1_s, clean, s2_s, s2)
    return lag if lag.correlation >= TRUSTED else Lag(0.0, 0.0, lag.correlation)


def _noise_of(values: Reals) -> float:
    """Return the white noise in a series; never 0."""
    return max(white_noise(values), 1e-3 * float(np.std(values)), _TINY)


def _allowed(noise: float) -> float:
    """Return a noise within what the parameters allow; only ratios matter."""
    return min(max(noise, _TINY), 1e9)
