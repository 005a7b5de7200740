# SPDX-License-Identifier: Apache-2.0
"""S1 cleaned with hindsight: its spikes replaced, its noise removed without delay."""

from __future__ import annotations

import itertools

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, white_noise
from fuzzy_fusion_ros.batch.smoothing import smoothed
from fuzzy_fusion_ros.self_tuning.spikes import FEWEST_SPIKES, SIGMA_OVER_MEDIAN, SPIKE_SIGMAS

DETECTING = 5
"""Samples each way in the median that detects spikes: few, so that motion is not taken for one."""

REMOVING = 8
"""Samples each way in the median that replaces spikes: enough to outnumber a run of them."""

_TINY = 1e-300

_NO_STEP = 1e-12
"""In a series that rests without noise, no sample this close to the median is a spike."""


def without_spikes(s1: Reals) -> tuple[Reals, float, float]:
    """Return a series with its spikes replaced by the median around them, if it has enough.

    Returns:
        The series, the share of spikes, and the usual distance of a sample from the median.
    """
    _, share, scale = _limited(s1, DETECTING)
    if share < FEWEST_SPIKES:
        return s1, share, scale
    return _limited(s1, REMOVING)


def _limited(s1: Reals, half: int) -> tuple[Reals, float, float]:
    windows = np.lib.stride_tricks.sliding_window_view(
        np.pad(s1, half, mode="reflect"), 2 * half + 1
    )
    median = np.median(windows, axis=1)
    distance = np.abs(s1 - median)
    steps = np.median(np.abs(np.diff(windows, axis=1)), axis=1)
    scale = SIGMA_OVER_MEDIAN * max(
        float(np.quantile(steps, 0.7)),  # motion now and then is no spike
        float(np.median(distance)),
        float(np.quantile(distance, 0.8)) / 2.0,
    )
    spike = distance > SPIKE_SIGMAS * scale + _NO_STEP
    return np.where(spike, median, s1), float(np.mean(spike)), scale


def without_noise(s1_s: Reals, s1: Reals, s2_interval: float) -> Reals:
    """Return S1 without its noise and without delay: octave bands, each with its Wiener gain.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1, free of spikes, shape (n,).
        s2_interval: Median time between samples of S2, seconds; much slower bands stay as they
            are.
    """
    slowest = max(4.0 * s2_interval, 1.0)
    layers = [s1]
    time_constant = float(np.median(np.diff(s1_s)))
    while time_constant < slowest:
        layers.append(smoothed(s1_s, s1, time_constant))
        time_constant *= 2.0
    bands = [fast - slow for fast, slow in itertools.pairwise(layers)]
    if not bands:
        return s1
    gains = _wiener_gains(np.array([np.mean(np.square(each)) for each in bands]), white_noise(s1))
    clean = layers[-1].copy()
    for gain, band in zip(gains, bands, strict=True):
        clean += gain * band
    return clean


def _wiener_gains(powers: Reals, noise: float) -> Reals:
    """Return the share of signal in each band, the fastest first.

    A signal's power falls towards fast octave bands. Where S1's rises again it is noise, taken as
    white from there on; where it never rises, the noise is that of second differences.
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
