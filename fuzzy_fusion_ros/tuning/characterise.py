"""What the sensors of a recording are like: rates, noise, spikes, lag, bias."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.core.series import Reals, Series
from fuzzy_fusion_ros.tuning.errors import TuneError
from fuzzy_fusion_ros.tuning.lag import Lag, read_through, trusted_lag
from fuzzy_fusion_ros.tuning.times import held_s2, seconds

FEWEST_S1 = 50
FEWEST_S2 = 10
"""With fewer samples there is nothing to see."""

TELLING = 5
"""Samples each way that tell whether S1 has spikes at all: few, so that motion is none."""

REMOVING = 8
"""Samples each way that tell which samples are spikes, where there are any: runs of them too."""

SPIKE_SIGMAS = 5.0
"""A sample this many times the usual step from the median around it is a spike."""

FEWEST_SPIKES = 0.015
"""From this share of spikes on they are a fault of the sensor; fewer are the tail of its noise."""

_TO_SIGMA = 1.4826
"""The standard deviation of normal numbers over their median magnitude."""

TINY = 1e-12


class Characteristics(NamedTuple):
    """What the sensors of a recording are like.

    Attributes:
        span: Length of the recording, s.
        s1_interval: Median time between samples of S1, s.
        s2_interval: Median time between samples of S2, s.
        s2_gap: Longest time between samples of S2, s.
        s1_noise: Standard deviation of S1's white noise, unit of the signal.
        spike_share: Share of S1's samples that are spikes.
        spike_scale: Usual distance of a sample from the median around it, unit of the signal.
        lag: Delay and time constant of S2 against S1.
        chance: Correlation through a lag that unrelated sensors would reach by chance; 0 where
            that of these is beyond doubt.
        bias: Mean of what S2 would read if S1 were right less what it reads, unit of the signal.
        drift: Slope of that over the recording, unit of the signal per second.
        wander: What is left of it about that line, standard deviation, unit of the signal.
        difference: Median of ``|S1 - S2|``, unit of the signal.
        rate: Root mean square of dS2/dt, unit of the signal per second.
    """

    span: float
    s1_interval: float
    s2_interval: float
    s2_gap: float
    s1_noise: float
    spike_share: float
    spike_scale: float
    lag: Lag
    chance: float
    bias: float
    drift: float
    wander: float
    difference: float
    rate: float

    @property
    def has_spikes(self) -> bool:
        """Whether S1 has spikes that are worth rejecting."""
        return self.spike_share >= FEWEST_SPIKES

    @property
    def related(self) -> bool:
        """Whether S1 and S2 have more in common than chance gives."""
        return self.lag.correlation > self.chance


def characterise(series: Series) -> Characteristics:
    """Tell what the sensors of a recording are like.

    Raises:
        TuneError: There are too few samples, or no two samples of S2 differ.
    """
    require_enough(series)
    s1_s, s2_s = seconds(series)
    s1, spike_share, spike_scale = without_spikes(series.s1)
    lag, chance = trusted_lag(s1_s, s1, s2_s, series.s2)
    error = read_through(lag, s1_s, s1, s2_s) - series.s2
    about = s2_s - s2_s.mean()
    drift = float(about @ error / (about @ about))
    known = series.s2_known > 0
    apart = np.abs(held_s2(series) - s1)[known]
    return Characteristics(
        span=float(s1_s[-1] - s1_s[0]),
        s1_interval=float(np.median(np.diff(s1_s))),
        s2_interval=float(np.median(np.diff(s2_s))),
        s2_gap=float(np.diff(s2_s).max()),
        s1_noise=white_noise(s1),
        spike_share=spike_share,
        spike_scale=spike_scale,
        lag=lag,
        chance=chance,
        bias=float(error.mean()),
        drift=drift,
        wander=float(np.std(error - drift * about)),
        difference=max(float(np.median(apart)), TINY),
        rate=max(root_mean_square(np.diff(series.s2) / np.diff(s2_s)), TINY),
    )


def require_enough(series: Series) -> None:
    """Check that there is something to fit to.

    Raises:
        TuneError: There are too few samples, S2 does not move, or all of it comes after S1.
    """
    for name, size, fewest in (
        ("S1", series.s1.size, FEWEST_S1),
        ("S2", series.s2.size, FEWEST_S2),
    ):
        if size < fewest:
            raise TuneError(
                f"got {size} samples of {name}, expected {fewest} at least: take a longer span"
            )
    if np.ptp(series.s2) == 0.0:
        raise TuneError(
            f"S2 is {series.s2[0]:g} in all {series.s2.size} samples, expected a signal that moves"
        )
    if np.count_nonzero(series.s2_known) < FEWEST_S1:
        raise TuneError(
            f"got {np.count_nonzero(series.s2_known)} samples of S1 after the first of S2, "
            f"expected {FEWEST_S1} at least: do both cover the span?"
        )


def without_spikes(s1: Reals) -> tuple[Reals, float, float]:
    """Return a series with its spikes replaced by the median around them, if it has enough.

    Returns:
        The series, the share of spikes, and the usual distance of a sample from the median.
    """
    _, share, scale = _limited(s1, TELLING)
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
    scale = _TO_SIGMA * max(
        float(np.quantile(steps, 0.7)),  # so a signal that moves now and then is no spike
        float(np.median(distance)),
        float(np.quantile(distance, 0.8)) / 2.0,
    )
    spike = distance > SPIKE_SIGMAS * scale + TINY
    return np.where(spike, median, s1), float(np.mean(spike)), scale


def white_noise(values: Reals) -> float:
    """Return the standard deviation of the white noise in a series, from second differences."""
    return float(np.median(np.abs(np.diff(values, n=2))) * _TO_SIGMA / np.sqrt(6.0))


def root_mean_square(values: Reals) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
