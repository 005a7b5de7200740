# SPDX-License-Identifier: Apache-2.0
"""A reference to fit to where there is no truth: the recording smoothed with hindsight.

A smoother, which may look ahead, knows more than any filter: S1 without its noise, removed in
octave bands without delay, and without its bias, which follows from S2 before and after, seen
through its lag.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square
from fuzzy_fusion_ros.batch.cleaning import without_noise, without_spikes
from fuzzy_fusion_ros.batch.lag import read_through
from fuzzy_fusion_ros.batch.series import Series, held_s2, seconds
from fuzzy_fusion_ros.batch.smoothing import smoothed
from fuzzy_fusion_ros.tuning.characterise import Characteristics

_SMOOTHING_TIMES = 18
_NEARLY = 1.02
"""The longest smoothing is used that predicts S1's bias within 2 % of the best."""


class _Smoothing(NamedTuple):
    """A way to smooth S1's bias.

    Attributes:
        misfit: Root mean square error at samples left out, unit of the signal.
        time_constant: Seconds; infinite: the bias is a constant.
        straight: Whether local lines are fitted rather than local means.
    """

    misfit: float
    time_constant: float
    straight: bool

    def of(self, s2_s: Reals, error: Reals) -> Reals:
        """Return the bias at the times of S2, shape (m,)."""
        return smoothed(s2_s, error, self.time_constant, self.straight)


def reference_without_truth(series: Series, sensors: Characteristics) -> Reals:
    """Return the signal as reconstructed with hindsight at each S1 sample, shape (n,).

    Where S1 is unrelated to S2 the reference is S2, held. No bias is removed where S1 predicts S2
    equally well without, and a constant one where that is enough.

    Args:
        series: The recording.
        sensors: What its sensors are like.
    """
    if not sensors.related:
        return held_s2(series)
    s1_s, s2_s = seconds(series)
    s1 = without_spikes(series.s1)[0]
    clean = without_noise(s1_s, s1, sensors.s2_interval)
    error = read_through(sensors.lag, s1_s, clean, s2_s) - series.s2
    smoothing = _best_smoothing(s2_s, error, sensors)
    if root_mean_square(error) <= _NEARLY * smoothing.misfit:
        return clean
    bias = smoothing.of(s2_s, error)
    return clean - np.interp(s1_s, s2_s - sensors.lag.total, bias)


def _best_smoothing(s2_s: Reals, error: Reals, sensors: Characteristics) -> _Smoothing:
    """Return the longest of the smoothings that predict the bias well where S2 is left out.

    A constant is the longest of all.
    """
    hole = max(3.0 * sensors.lag.total, 1.5 * sensors.s2_interval)
    times = np.geomspace(
        0.1 * sensors.s2_interval, max(100.0 * sensors.s2_interval, 60.0), _SMOOTHING_TIMES
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
