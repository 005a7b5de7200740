"""How S2 lags behind S1: a delay, then a first-order lag."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.series import Reals
from fuzzy_fusion_ros.tuning.smoothing import lagged

LONGEST = 5.0
"""Longest delay and time constant looked for, s."""

GRID = 18
"""Delays and time constants tried at first, from shortest to longest."""

REFINEMENTS = 3
"""Times that the grid is halved around the best."""

TRUSTED = 0.5
"""From this correlation on the lag is more than a guess."""

SHIFTS = 19
"""Shifts of S1 by which chance is judged: one in twenty unrelated pairs passes."""

_CLEARLY = 1e-4
"""So much more correlation makes a longer lag the better explanation."""


_FAR = 2.0
"""Where outliers are limited, a change of S2 counts as at most twice one that exceeds 9 in 10."""


class Lag(NamedTuple):
    """S2's lag behind S1.

    Attributes:
        delay: Pure delay, s.
        time_constant: First-order time constant, s.
        correlation: Of the changes of S2 with those of S1 seen through this lag: 1 is perfect,
            and from 0.5 down the lag is a guess.
    """

    delay: float
    time_constant: float
    correlation: float

    @property
    def total(self) -> float:
        """Delay and time constant together, s."""
        return self.delay + self.time_constant


class _Changes(NamedTuple):
    """Changes of S2 over a number of samples.

    Attributes:
        over: How many.
        usable: Where no gap is between both, shape (m - over,).
        s2: The changes there.
    """

    over: int
    usable: NDArray[np.bool_]
    s2: Reals


def trusted_lag(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals) -> tuple[Lag, float]:
    """Find the lag, and the correlation that unrelated sensors of this kind would reach.

    Where S1 explains little of S2, outliers of S2 may be why: then the lag is found with these
    limited. Where that does not help either, chance is judged by the largest correlation found
    with S1 shifted by long parts of the recording, its end put in front: what is left of its
    motion has nothing to do with S2 then.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1, free of spikes, shape (n,).
        s2_s: Times of S2, shape (m,), seconds.
        s2: S2, shape (m,).

    Returns:
        The lag, and chance: 0 where the lag is beyond doubt.
    """
    lag = lag_of(s1_s, s1, s2_s, s2)
    if lag.correlation >= TRUSTED:
        return lag, 0.0
    lag = lag_of(s1_s, s1, s2_s, s2, limited=True)
    if lag.correlation >= TRUSTED:
        return lag, 0.0
    shifts = [(k + 1) * s1.size // (SHIFTS + 1) for k in range(SHIFTS)]
    shifted = [lag_of(s1_s, np.roll(s1, each), s2_s, s2, limited=True) for each in shifts]
    return lag, max(each.correlation for each in shifted)


def lag_of(s1_s: Reals, s1: Reals, s2_s: Reals, s2: Reals, limited: bool = False) -> Lag:
    """Find the lag at which the changes of S1, seen through it, correlate most with those of S2.

    Changes do not see a bias, and hardly a drift. Both are looked at from sample to sample of
    S2 and, where that is noisier, over a second.

    Args:
        s1_s: Times of S1, shape (n,), seconds.
        s1: S1, free of spikes, shape (n,).
        s2_s: Times of S2, shape (m,), seconds.
        s2: S2, shape (m,).
        limited: Whether large changes of S2 count less.
    """
    shortest = float(np.median(np.diff(s1_s)))
    interval = float(np.median(np.diff(s2_s)))
    longest = min(LONGEST, float(s2_s[-1] - s2_s[0]) / 20.0)
    grid = np.geomspace(max(shortest / 2.0, longest / 500.0), max(longest, shortest), GRID)
    factor = float((grid[-1] / grid[0]) ** (1.0 / (GRID - 1)))
    strides = {1, max(1, min(round(1.0 / interval), s2.size // 4))}
    kinds = [_changes(over, interval, s2_s, s2, limited) for over in sorted(strides)]
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


def read_through(lag: Lag, s1_s: Reals, s1: Reals, s2_s: Reals) -> Reals:
    """Return what S2 would read if S1 were right, at the times of S2, shape (m,)."""
    behind = lagged(s1_s, s1, lag.time_constant)
    return np.interp(s2_s - lag.delay, s1_s, behind)


def _changes(over: int, interval: float, s2_s: Reals, s2: Reals, limited: bool) -> _Changes:
    usable = (s2_s[over:] - s2_s[:-over]) < 3.0 * over * interval
    changes = (s2[over:] - s2[:-over])[usable]
    if limited and changes.size:
        most = _FAR * float(np.quantile(np.abs(changes), 0.9))
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
