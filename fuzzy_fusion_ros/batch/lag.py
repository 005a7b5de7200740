# SPDX-License-Identifier: Apache-2.0
"""How S2 lags behind S1: a delay, then a first-order lag.

Instead of the peak of a cross-correlation, which knows one shift only and misses S2's lag by 0.50 s
(root mean square over the stand-ins of ``test/tuning``, 0.25 to 1 s late) where this misses it by
0.04 s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.batch.bursts import bursts_of
from fuzzy_fusion_ros.batch.smoothing import lagged

LONGEST = 5.0
"""Longest delay and time constant tried at first, s."""

FURTHER = 3.0
"""Longer ones by this factor are tried as long as the best is near the longest or uncertain."""

SHARE_OF_SPAN = 0.05
"""Longest delay and time constant tried at all, as a share of the recording."""

CHANGES_OVER = 0.2
"""Changes are also taken over this share of the longest lag tried: less noisy ones."""

GRID = 18
"""Delays, and time constants, tried in the first pass."""

REFINEMENTS = 3
"""Passes on a finer grid around the best."""

TRUSTED = 0.5
"""From this correlation on, a fit starts from the lag that was measured."""

GUESS_BELOW = 0.7
"""Below this correlation, S1 explains less than half of S2: its lag is called a guess."""

SHIFTS = 19
"""Rotations of S1 that measure chance: one in twenty unrelated pairs passes."""

_CLEARLY = 1e-4
"""A longer lag must raise the correlation by this to be preferred."""

_CLIPPED_AT = 2.0
"""Changes of S2 are clipped at this multiple of their 90th percentile."""


class Lag(NamedTuple):
    """S2's lag behind S1.

    Attributes:
        delay: Pure delay, s.
        time_constant: First-order time constant, s.
        correlation: Of the changes of S2 with those of S1 seen through this lag; 1 is perfect,
            and below 0.7 the lag is called a guess.
    """

    delay: float
    time_constant: float
    correlation: float

    @property
    def total(self) -> float:
        """Sum of delay and time constant, s."""
        return self.delay + self.time_constant


class _Changes(NamedTuple):
    """Changes of S2 over a number of samples.

    Attributes:
        over: How many.
        usable: Which of them span no gap, shape (m - over,).
        s2: Those changes.
    """

    over: int
    usable: Flags
    s2: Reals


def lag_of(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals) -> Lag:
    """Find the lag at which the changes of S1, seen through it, correlate most with those of S2.

    Changes do not contain a bias, and hardly any drift. They are taken from sample to sample of
    S2 and, because that may be noisy, over a longer time. Where S1 explains little of S2, outliers
    of S2 may be the reason, so the search is repeated with large changes of S2 clipped.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1 without spikes and noise, shape (n,): noise would favour a long lag, which removes
            it.
        s2_s: Times of S2, shape (m,), seconds.
        s2: S2, shape (m,).
    """
    lag = _lag_of(s1_s, s1, s2_s, s2, clipped=False)
    if lag.correlation >= TRUSTED:
        return lag
    return _lag_of(s1_s, s1, s2_s, s2, clipped=True)


def chance_correlation(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals) -> float:
    """Return the correlation that :func:`lag_of` would find between unrelated sensors.

    It is the largest over S1 rotated by long parts of the recording: the motion of S1 then has
    nothing to do with that of S2.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1 without spikes and noise, shape (n,).
        s2_s: Times of S2, shape (m,), seconds.
        s2: S2, shape (m,).
    """
    shifts = [(k + 1) * s1.size // (SHIFTS + 1) for k in range(SHIFTS)]
    rotated = [_lag_of(s1_s, np.roll(s1, each), s2_s, s2, clipped=True) for each in shifts]
    return max(each.correlation for each in rotated)


def read_through(lag: Lag, s1_s: Reals, s1: Reals, s2_s: Reals) -> Reals:
    """Return what S2 would read if S1 were right, at the times of S2, shape (m,)."""
    return np.interp(s2_s - lag.delay, s1_s, lagged(s1_s, s1, lag.time_constant))


def _lag_of(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals, clipped: bool) -> Lag:
    limit = SHARE_OF_SPAN * float(s2_s[-1] - s2_s[0])
    longest = min(LONGEST, limit)
    lag = _lag_up_to(longest, s1_s, s1, s2_s, s2, clipped)
    while longest < limit and (
        lag.correlation < TRUSTED or max(lag.delay, lag.time_constant) > longest / FURTHER
    ):
        longest = min(FURTHER * longest, limit)
        longer = _lag_up_to(longest, s1_s, s1, s2_s, s2, clipped)
        if longer.correlation > lag.correlation + _CLEARLY:
            lag = longer
    return lag


def _lag_up_to(
    longest: float, s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals, clipped: bool
) -> Lag:
    shortest = float(np.median(np.diff(s1_s)))
    interval = bursts_of(s2_s).interval
    grid = np.geomspace(max(shortest / 2.0, longest / 500.0), max(longest, shortest), GRID)
    factor = float((grid[-1] / grid[0]) ** (1.0 / (GRID - 1)))
    strides = {1, max(1, min(round(CHANGES_OVER * longest / interval), s2.size // 4))}
    kinds = [_changes(over, interval, s2_s, s2, clipped) for over in sorted(strides)]
    tried = np.append(0.0, grid)
    found = [_search(s1_s, s1, s2_s, each, tried, tried) for each in kinds]
    best = max(range(len(kinds)), key=lambda k: found[k].correlation)
    lag, changes = found[best], kinds[best]
    for _ in range(REFINEMENTS):
        factor = factor**0.5
        delays = _around(lag.delay, factor, grid[0])
        time_constants = _around(lag.time_constant, factor, grid[0])
        finer = _search(s1_s, s1, s2_s, changes, delays, time_constants)
        lag = max(lag, finer, key=lambda each: each.correlation)
    return lag


def _changes(over: int, interval: float, s2_s: Reals, s2: Reals, clipped: bool) -> _Changes:
    usable = (s2_s[over:] - s2_s[:-over]) < 3.0 * over * interval
    changes = (s2[over:] - s2[:-over])[usable]
    if clipped and changes.size:
        most = _CLIPPED_AT * float(np.quantile(np.abs(changes), 0.9))
        changes = np.clip(changes, -most, most)
    return _Changes(over, usable, changes)


def _search(
    s1_s: Reals,
    s1: Reals,
    s2_s: Reals,
    changes: _Changes,
    delays: Reals,
    time_constants: Reals,
) -> Lag:
    best = Lag(0.0, 0.0, -2.0)
    for time_constant in time_constants:
        behind = lagged(s1_s, s1, float(time_constant))
        for delay in delays:
            correlation = _correlation(np.interp(s2_s - delay, s1_s, behind), changes)
            if correlation > best.correlation + _CLEARLY:
                best = Lag(float(delay), float(time_constant), correlation)
    return best


def _correlation(seen: Reals, changes: _Changes) -> float:
    s1 = (seen[changes.over :] - seen[: -changes.over])[changes.usable]
    norm = float(np.sqrt(s1 @ s1) * np.sqrt(changes.s2 @ changes.s2))
    return float(s1 @ changes.s2) / norm if norm > 0.0 else 0.0


def _around(value: float, factor: float, smallest: float) -> Reals:
    if value == 0.0:
        return np.array([0.0, smallest / 2.0])
    return np.array(value * factor ** np.arange(-2.0, 3.0))
