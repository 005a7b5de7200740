# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a recording are like: rates, noise, spikes, lag and bias."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import root_mean_square, white_noise
from fuzzy_fusion_ros.batch.bursts import bursts_of
from fuzzy_fusion_ros.batch.cleaning import (
    without_noise,
    without_spikes,
)
from fuzzy_fusion_ros.batch.lag import (
    SHARE_OF_SPAN,
    TRUSTED,
    Lag,
    chance_correlation,
    lag_of,
    read_through,
)
from fuzzy_fusion_ros.batch.series import Series, held_s2, seconds
from fuzzy_fusion_ros.self_tuning.spikes import FEWEST_SPIKES
from fuzzy_fusion_ros.tuning.errors import TuneError

FEWEST_S1 = 50
FEWEST_S2 = 10
"""With fewer samples there is nothing to characterise."""

TINY = 1e-12

ONE_WAY = 0.7
"""Where S2 moves this steadily one way, its lag and S1's bias cannot be distinguished."""

QUIETEST = 1e-4
"""S2's noise is at least this share of S2's own standard deviation."""


class Characteristics(NamedTuple):
    """What the sensors of a recording are like.

    Attributes:
        span: Length of the recording, s.
        s1_interval: Median time between samples of S1, s.
        s2_interval: Median time between samples of S2, s; the mean if they come in bursts.
        s2_pause: Of the times between samples of S2, 95 % are no longer, s.
        s2_gap: Longest time between samples of S2, s.
        s2_delivery: How old a sample of S2 is on arrival, 99th percentile, s.
        s1_noise: Standard deviation of S1's white noise, unit of the signal.
        s2_noise: Standard deviation of S2's white noise, unit of the signal; more than 0.
        spike_share: Share of S1's samples that are spikes.
        spike_scale: Typical distance of a sample from the median around it, unit of the signal.
        lag: Delay and time constant of S2 against S1.
        chance: Correlation that unrelated sensors would reach by chance; 0 where that of these
            is beyond doubt.
        bias: Mean of S1, seen through the lag, minus S2, unit of the signal.
        drift: Slope of that difference over the recording, unit of the signal per second.
        wander: Standard deviation of that difference about its line, unit of the signal.
        difference: Median of ``|S1 - S2|``, unit of the signal.
        rate: Root mean square of dS2/dt, unit of the signal per second.
        one_way: Magnitude of the mean of dS2/dt, over ``rate``: 1 for a straight line.
        longest_lag: Longest delay and time constant that the search for the lag covers, s.
        clocks_agree: Whether both sensors are stamped by the same clock, as far as is known.
    """

    span: float
    s1_interval: float
    s2_interval: float
    s2_pause: float
    s2_gap: float
    s2_delivery: float
    s1_noise: float
    s2_noise: float
    spike_share: float
    spike_scale: float
    lag: Lag
    chance: float
    bias: float
    drift: float
    wander: float
    difference: float
    rate: float
    one_way: float
    longest_lag: float
    clocks_agree: bool = True

    @property
    def moves_one_way(self) -> bool:
        """Whether a lag of S2 looks the same as a bias of S1, so that neither can be determined."""
        return self.one_way > ONE_WAY

    @property
    def lag_at_limit(self) -> bool:
        """Whether the lag is at the edge of its search range, so that it is no measurement."""
        return max(self.lag.delay, self.lag.time_constant) >= self.longest_lag

    @property
    def lag_is_identifiable(self) -> bool:
        """Whether the lag is that of S2.

        It is not where the clocks disagree, the signal moves one way, S1 and S2 are unrelated, or
        the search ended at its longest lag.
        """
        distinct = self.related and not self.moves_one_way
        return self.clocks_agree and distinct and not self.lag_at_limit

    @property
    def has_spikes(self) -> bool:
        """Whether S1 has spikes that are worth rejecting."""
        return self.spike_share >= FEWEST_SPIKES

    @property
    def related(self) -> bool:
        """Whether S1 and S2 correlate more than chance explains."""
        return self.lag.correlation > self.chance


def characterise(series: Series) -> Characteristics:
    """Return what the sensors of a recording are like.

    Raises:
        TuneError: There are too few samples, or no two samples of S2 differ.
    """
    require_enough(series)
    s1_s, s2_s = seconds(series)
    s1, spike_share, spike_scale = without_spikes(series.s1)
    s2_interval = bursts_of(s2_s).interval
    clean = without_noise(s1_s, s1, s2_interval)
    lag = lag_of(s1_s, clean, s2_s, series.s2)
    sure = lag.correlation >= TRUSTED
    error = read_through(lag, s1_s, s1, s2_s) - series.s2
    about = s2_s - s2_s.mean()
    drift = float(about @ error / (about @ about))
    known = series.s2_known > 0
    apart = np.abs(held_s2(series) - s1)[known]
    rates = np.diff(series.s2) / np.diff(s2_s)
    rate = max(root_mean_square(rates), TINY)
    return Characteristics(
        span=float(s1_s[-1] - s1_s[0]),
        s1_interval=float(np.median(np.diff(s1_s))),
        s2_interval=s2_interval,
        s2_pause=float(np.quantile(np.diff(s2_s), 0.95)),
        s2_gap=float(np.diff(s2_s).max()),
        s2_delivery=_delivery(series),
        s1_noise=white_noise(s1),
        s2_noise=max(white_noise(series.s2), QUIETEST * float(np.std(series.s2)), TINY),
        spike_share=spike_share,
        spike_scale=spike_scale,
        lag=lag,
        chance=0.0 if sure else chance_correlation(s1_s, clean, s2_s, series.s2),
        bias=float(error.mean()),
        drift=drift,
        wander=float(np.std(error - drift * about)),
        difference=max(float(np.median(apart)), TINY),
        rate=rate,
        one_way=min(abs(float(rates.mean())) / rate, 1.0),
        longest_lag=SHARE_OF_SPAN * float(s2_s[-1] - s2_s[0]),
    )


def _delivery(series: Series) -> float:
    """Return how old samples of S2 are when they arrive: how long S1 went on without them."""
    without = np.searchsorted(series.s2_known, np.arange(series.s2.size), side="right") - 1
    age_s = (series.s1_ns[np.maximum(without, 0)] - series.s2_ns) * 1e-9
    age_s[without < 0] = 0.0  # there before the first of S1
    return float(np.quantile(np.maximum(age_s, 0.0), 0.99))


def require_enough(series: Series) -> None:
    """Check that the recording is long enough and that S2 moves.

    Raises:
        TuneError: There are too few samples, S2 is constant, or S1 ends before S2 starts.
    """
    for name, size, fewest in (
        ("S1", series.s1.size, FEWEST_S1),
        ("S2", series.s2.size, FEWEST_S2),
    ):
        if size < fewest:
            raise TuneError(
                f"got {size} samples of {name}, expected at least {fewest}: use a longer span"
            )
    if np.ptp(series.s2) == 0.0:
        raise TuneError(
            f"S2 is {series.s2[0]:g} in all {series.s2.size} samples, expected it to vary: use a "
            "span in which the signal moves"
        )
    if np.count_nonzero(series.s2_known) < FEWEST_S1:
        raise TuneError(
            f"got {np.count_nonzero(series.s2_known)} samples of S1 after the first of S2, "
            f"expected at least {FEWEST_S1}: use a span that both sensors cover"
        )
