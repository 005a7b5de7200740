# SPDX-License-Identifier: Apache-2.0
"""S1 through many models of S2 at a time: the one most like S2 has S2's lag."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.self_tuning.allan import Octaves, Reals, usual, vertex

SHORTEST, LONGEST, LAGS = 0.1, 30.0, 18
"""Lags tried, in intervals of S2, on a logarithmic scale, and how many; and none at all."""

SHARE_OF_SPAN = 0.05
"""Longest lag that counts, as a share of the time in which S1 was compared with S2."""

OCTAVES = 3
"""Octaves over which what S1 does not explain of S2 is compared: the shortest that are clear,
because longer ones are less noisy, but know the lag less well."""

CLEARLY = 0.2
"""A lag counts if it leaves less of S2 unexplained than S1 without lag and than S1 at rest, by this
much in the mean of logarithms over the octaves: else too little moved to tell."""

_NONE = 1e-9
"""Stands for a time constant of 0, seconds."""

_NOTHING = 1e-300


class LagBank(NamedTuple):
    """S1 behind two lags in a row, for many pairs of time constants; all of shape (k,).

    Attributes:
        lags: Time constants of the first, seconds; the pair at index 0 is no lag.
        delays: Time constants of the second, seconds: 0, or the same as the first.
        first: S1 behind the first, unit of the signal.
        second: S1 behind both.
    """

    lags: Reals
    delays: Reals
    first: Reals
    second: Reals


class FoundLag(NamedTuple):
    """S2's lag.

    Attributes:
        pair: The nearest pair of the bank.
        lag: Time constant of the first lag, seconds.
        delay: Of the second, which stands for a delay, seconds.
    """

    pair: int
    lag: float
    delay: float


def lag_bank(interval: float, s1: float) -> LagBank:
    """Return the bank for an S2 of an interval, in seconds, at a sample of S1."""
    grid = interval * np.geomspace(SHORTEST, LONGEST, LAGS)
    lags = np.concatenate([[_NONE], grid, 0.5 * grid])
    delays = np.concatenate([[_NONE], np.full(LAGS, _NONE), 0.5 * grid])
    shown = np.full(lags.size, s1)
    return LagBank(lags, delays, shown, shown)


def passed(bank: LagBank, dt: float, s1: float) -> LagBank:
    """Take a sample of S1, ``dt`` seconds after the last."""
    first = bank.first + (1.0 - np.exp(-dt / bank.lags)) * (s1 - bank.first)
    second = bank.second + (1.0 - np.exp(-dt / bank.delays)) * (first - bank.second)
    return LagBank(bank.lags, bank.delays, first, second)


def found_lag(
    bank: LagBank, errors: Octaves, span: float, late: float, before: FoundLag
) -> FoundLag:
    """Return the lag through which S1 moves most as S2 does.

    Args:
        bank: The bank.
        errors: Of S1 through each of its pairs, minus S2; and last of S1 at rest.
        span: Seconds in which they were compared.
        late: How long after their stamps samples of S2 came, which is no lag of theirs, seconds.
        before: The answer if nothing moved that could tell, or if the longest lag tried is best.
    """
    logs = np.log(np.maximum(usual(errors), _NOTHING))
    if not len(logs):
        return before
    is_tried = bank.lags + bank.delays < SHARE_OF_SPAN * span
    for start in range(max(len(logs) - OCTAVES, 0) + 1):
        misfit = logs[start : start + OCTAVES].mean(axis=0)
        index = int(np.argmin(np.where(is_tried, misfit[:-1], np.inf)))
        is_last = index in {LAGS, 2 * LAGS} or not is_tried[index + 1]
        if not is_last and misfit[index] < min(misfit[0], misfit[-1]) - CLEARLY:
            return _between(bank, misfit, index, late)
    return before


def _between(bank: LagBank, misfit: Reals, pair: int, late: float) -> FoundLag:
    """Return the lag at the least misfit near a pair of the bank."""
    own = misfit[1 : 1 + LAGS] if pair <= LAGS else misfit[1 + LAGS : -1]
    factor = float(bank.lags[2] / bank.lags[1]) ** vertex(own, (pair - 1) % LAGS)
    factor *= max(1.0 - late / (factor * float(bank.lags[pair] + bank.delays[pair])), 0.0)
    lag, delay = float(bank.lags[pair]) * factor, float(bank.delays[pair]) * factor
    return FoundLag(pair, lag, delay if pair > LAGS else 0.0)
