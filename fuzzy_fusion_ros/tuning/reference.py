"""Something to fit to where there is no truth: the recording smoothed with hindsight.

A filter that may look ahead knows more than any that may not: S1, its noise taken off by octave
bands without delay, less its bias, which S2 tells through its lag from both sides in time.
"""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.core.series import Reals, Series
from fuzzy_fusion_ros.tuning.characterise import Characteristics, root_mean_square, without_spikes
from fuzzy_fusion_ros.tuning.lag import read_through
from fuzzy_fusion_ros.tuning.smoothing import smoothed
from fuzzy_fusion_ros.tuning.times import held_s2, seconds

_SMOOTHING_TIMES = 18
_NEARLY = 1.02
"""A longer smoothing that predicts S1's bias within 2 % as well as the best is taken."""

_TINY = 1e-300


class _Smoothing(NamedTuple):
    """A way to smooth S1's bias.

    Attributes:
        misfit: Of what it says to what was left out, unit of the signal.
        time_constant: Seconds; infinite: the bias is a constant.
        straight: Whether by lines.
    """

    misfit: float
    time_constant: float
    straight: bool

    def of(self, s2_s: Reals, error: Reals) -> Reals:
        """Return the bias at the times of S2, shape (m,)."""
        return smoothed(s2_s, error, self.time_constant, self.straight)


def reference_without_truth(series: Series, found: Characteristics) -> Reals:
    """Return the signal as hindsight tells it, at each S1 sample, shape (n,).

    Where S1 has nothing to do with S2 that is S2 as it comes. Where S1 as it is predicts S2, or
    less a constant, it has no bias, or a constant one.

    Args:
        series: The recording.
        found: What its sensors are like.
    """
    if not found.related:
        return held_s2(series)
    s1_s, s2_s = seconds(series)
    s1 = without_spikes(series.s1)[0]
    clean = without_noise(s1_s, s1, found)
    error = read_through(found.lag, s1_s, clean, s2_s) - series.s2
    smoothing = _best_smoothing(s2_s, error, found)
    if root_mean_square(error) <= _NEARLY * smoothing.misfit:
        return clean  # S1 as it is predicts S2 as well as S1 less any bias
    bias = smoothing.of(s2_s, error)
    return clean - np.interp(s1_s, s2_s - found.lag.total, bias)


def without_noise(s1_s: Reals, s1: Reals, found: Characteristics) -> Reals:
    """Return S1 less its noise, without delay: octave bands, each with its own Wiener gain.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1, free of spikes, shape (n,).
        found: What the sensors are like.
    """
    slowest = max(4.0 * found.s2_interval, 4.0 * found.lag.total, 1.0)
    layers = [s1]
    time_constant = found.s1_interval
    while time_constant < slowest:
        layers.append(smoothed(s1_s, s1, time_constant))
        time_constant *= 2.0
    bands = [fast - slow for fast, slow in itertools.pairwise(layers)]
    if not bands:
        return s1
    gains = _wiener_gains(np.array([np.mean(np.square(each)) for each in bands]), found.s1_noise)
    clean = layers[-1].copy()
    for gain, band in zip(gains, bands, strict=True):
        clean += gain * band
    return clean


def _wiener_gains(powers: Reals, noise: float) -> Reals:
    """Return the share of signal in each band, from the fastest.

    A signal's power in octave bands falls towards fast ones; where S1's rises again it is noise,
    white there. Where it never rises, the noise is what second differences tell.
    """
    octave = np.arange(powers.size)
    quietest = int(np.argmin(powers))
    if quietest == 0:
        noise_powers = noise**2 * 2.0**-octave
    else:
        noise_powers = 0.5 * powers[quietest] * 2.0 ** (quietest - octave)
    gains = np.clip(1.0 - noise_powers / np.maximum(powers, _TINY), 0.0, 1.0)
    signal_powers = 0.5 * powers[quietest] * 4.0 ** (octave[:quietest] - quietest)
    gains[:quietest] = np.clip(signal_powers / np.maximum(powers[:quietest], _TINY), 0.0, 1.0)
    monotonic: Reals = np.minimum.accumulate(gains[::-1])[::-1]
    return monotonic


def _best_smoothing(s2_s: Reals, error: Reals, found: Characteristics) -> _Smoothing:
    """Return the longest of the smoothings that predict the bias across a hole well.

    A constant is the longest of all.
    """
    hole = max(3.0 * found.lag.total, 1.5 * found.s2_interval)
    times = np.geomspace(
        0.1 * found.s2_interval, max(100.0 * found.s2_interval, 60.0), _SMOOTHING_TIMES
    )
    tried = [
        _Smoothing(
            root_mean_square(error - smoothed(s2_s, error, float(each), straight, hole)),
            float(each),
            straight,
        )
        for each in times
        for straight in (False, True)
    ]
    best = min(tried)
    constant = smoothed(s2_s, error, math.inf, False, hole)
    misfit = root_mean_square(error - constant)
    if misfit <= _NEARLY * best.misfit:
        return _Smoothing(misfit, math.inf, False)
    good = [
        each
        for each in tried
        if each.straight == best.straight and each.misfit <= _NEARLY * best.misfit
    ]
    return good[-1]
