"""Parameters of the baselines as one would set them by hand after a look at the recording."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.signal import correlate, detrend

from fuzzy_fusion_ros.baselines.parameters import (
    BaselineParameters,
    ComplementaryParameters,
    KalmanParameters,
)
from fuzzy_fusion_ros.batch.series import Series

Reals = NDArray[np.float64]

_FEWEST = 8
"""With fewer samples of either sensor there is nothing to look at."""
_BLOCKS = 16
_MOST_POINTS = 1_000_000
_TINY = 1e-9


def baselines_for(series: Series) -> BaselineParameters:
    """Derive parameters from noise, motion and lag as the recording shows them; not tuned.

    Args:
        series: The recording; a very short one gives the plain defaults.
    """
    if min(series.s1.size, series.s2.size) < _FEWEST:
        return BaselineParameters()
    span = float(_seconds(series.s2_ns, series.s2_ns[0])[-1])
    period = span / (series.s2.size - 1)
    lag = lag_between(series)
    s1_noise = _noise_of(series.s1)
    s2_noise = _noise_of(series.s2)
    apart = series.s1 - np.interp(series.s1_ns, series.s2_ns, series.s2)
    steps = float(np.mean(np.square(np.diff(series.s2))))
    walked = max(steps - 2.0 * s2_noise**2, 0.01 * steps, _TINY**2)
    process_noise = math.sqrt(walked / period)
    stale = math.sqrt(walked * (lag + 0.5 * period) / period + s2_noise**2)
    inaccuracy = max(_root_mean_square(apart), s1_noise)
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


def lag_between(series: Series) -> float:
    """Return how far S2 lags behind S1 in s: where both correlate most; slow drifts do not count.

    White noise on either does not bias it. It is 0 at the least.
    """
    begin_ns = max(series.s1_ns[0], series.s2_ns[0])
    s1_s = _seconds(series.s1_ns, begin_ns)
    s2_s = _seconds(series.s2_ns, begin_ns)
    end_s = min(s1_s[-1], s2_s[-1])
    period = max(float(np.median(np.diff(s1_s))), end_s / _MOST_POINTS)
    grid = np.arange(0.0, end_s, period)
    if grid.size < _BLOCKS:
        return 0.0
    s1 = _without_drift(np.interp(grid, s1_s, series.s1))
    s2 = _without_drift(np.interp(grid, s2_s, series.s2))
    similarity = correlate(s2, s1, mode="full", method="fft")[s1.size - 1 :]
    return float(period * np.argmax(similarity[: s1.size // _BLOCKS]))


def _without_drift(values: Reals) -> Reals:
    """Return values less a line in each block of them."""
    breaks = np.linspace(0, values.size, _BLOCKS + 1).astype(np.int64)[1:-1]
    straight: Reals = detrend(values, bp=breaks)
    return straight


def _noise_of(values: Reals) -> float:
    """Return the white noise in a series, from its second differences; never 0."""
    second = np.abs(np.diff(values, n=2))
    noise = float(np.median(second)) / (0.6745 * math.sqrt(6.0))
    return max(noise, 1e-3 * float(np.std(values)), _TINY)


def _allowed(noise: float) -> float:
    """Return a noise within what the parameters allow; only ratios matter."""
    return min(max(noise, _TINY), 1e9)


def _root_mean_square(values: Reals) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _seconds(stamps_ns: NDArray[np.int64], origin_ns: int) -> Reals:
    return (stamps_ns - origin_ns).astype(np.float64) * 1e-9
