# SPDX-License-Identifier: Apache-2.0
"""Which of many numbers move together: all pairs are compared coarsely, the best ones closely."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Flags, Reals
from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.pair import BEYOND_DOUBT, RELATED
from fuzzy_fusion_ros.checking.relation import Comparison, Kind, Relation
from fuzzy_fusion_ros.core.numerics import LARGEST
from fuzzy_fusion_ros.messages.units import RATES

POINTS = 1024
"""Points of the grid on which all pairs are compared."""

SPANS = (2, 8, 32)
"""Steps of that grid over which changes are taken; they are compared every half of it."""

LAGS = (-2, -1, 0, 1, 2)
"""Lags that are tried there, in half spans."""

MOST_FIELDS = 8000
"""Fields that are compared, those with most samples: the work grows with the square."""

ROWS = 500
"""Fields that are compared with all others at a time, to bound memory."""

CANDIDATES = 200
"""Pairs that are looked at closely, those with the largest correlation on the grid."""

COARSE = 0.4
"""Correlation there from which on a pair is looked at closely."""

FEWEST_SAMPLES = 20
"""Fields with fewer samples are left out."""

NOTHING = 1e-6
"""What changes by less than this share of its steps is a constant or a counter."""

SAME_INTERVAL = 1.5
"""Of fields whose intervals differ by less than this factor, the one that is ahead is S1."""

CLOSE_POINTS = 2048
"""Points of the grid of the close look."""


class Field(NamedTuple):
    """A number in the messages of a topic.

    Attributes:
        topic: The topic.
        path: Where the number is.
        unit: Its unit, ``""`` where the type states none.
        motion: What it did.
    """

    topic: str
    path: str
    unit: str
    motion: Motion


class Together(NamedTuple):
    """Two fields that move together.

    Attributes:
        s1: The one with the shorter interval or, if these are similar, the one that is ahead.
        s2: The other.
        relation: What they are to each other.
    """

    s1: Field
    s2: Field
    relation: Relation


def survey(fields: Sequence[Field]) -> list[Together]:
    """Return the pairs of fields that move together, most certain first.

    Fields of one topic, such as a gyro's rate and an accelerometer's tilt, are paired only where
    their units say that one is the rate of the other.

    Args:
        fields: The fields.
    """
    moving = [each for each in fields if moves(each.motion)]
    moving = sorted(moving, key=lambda each: -each.motion.values.size)[:MOST_FIELDS]
    if len(moving) < 2:
        return []
    # among this many pairs some reach this multiple of chance
    times = math.sqrt(2.0 * math.log(max(2, len(moving) * (len(moving) - 1) // 2)))
    pairs = (_pair(moving[i], moving[j]) for i, j in _candidates(moving))
    sure = [each.together() for each in pairs if each is not None and each.is_sure(times)]
    return sorted(sure, key=lambda each: -each.relation.correlation)


def moves(motion: Motion) -> bool:
    """Return whether a number changes, has enough samples, and squares that do not overflow."""
    if motion.values.size < FEWEST_SAMPLES or np.abs(motion.values).max() > LARGEST:
        return False
    return bool(np.ptp(motion.values) > 0.0)


class _Pair(NamedTuple):
    """Two fields and how they compare, by at least one relation."""

    s1: Field
    s2: Field
    compared: Comparison

    @property
    def relation(self) -> Relation:
        """The most credible relation."""
        return self.compared.relations[0]

    def is_sure(self, times: float) -> bool:
        """Return whether the relation is more than chance, this many times it for a weak one."""
        r = self.relation.correlation
        return r >= BEYOND_DOUBT or r >= max(RELATED, times * self.relation.chance)

    def together(self) -> Together:
        """Return the pair with its lag by itself."""
        lag = self.compared.lag_of(self.relation)
        return Together(self.s1, self.s2, self.relation._replace(lag=lag))


def _pair(one: Field, other: Field) -> _Pair | None:
    """Return what two fields are to each other; None if there is no relation."""
    s1, s2 = sorted((one, other), key=lambda each: each.motion.interval)
    best = _compared(s1, s2)
    if best is None or s2.motion.interval >= SAME_INTERVAL * s1.motion.interval:
        return best
    if best.relation.kind is Kind.S2_RATE:  # a rate is the fast sensor
        return _compared(s2, s1) or best
    if best.relation.kind is Kind.VALUE and best.relation.lag < 0.0:
        return min((best, _compared(s2, s1) or best), key=lambda each: each.relation.cost)
    return best


def _compared(s1: Field, s2: Field) -> _Pair | None:
    compared = Comparison(s1.motion, s2.motion, CLOSE_POINTS)
    return _Pair(s1, s2, compared) if compared.relations else None


def _candidates(fields: Sequence[Field]) -> list[tuple[int, int]]:
    """Return places of pairs to be looked at, those that correlate most on the grid."""
    topics = np.unique([each.topic for each in fields], return_inverse=True)[1]
    steps = _steps(fields)
    found: list[tuple[float, int, int]] = []
    for first in range(0, len(fields), ROWS):
        rows = np.arange(first, min(first + ROWS, len(fields)))
        columns = np.arange(first, len(fields))
        best = _correlations(steps, rows, first)
        is_one_topic = topics[rows, None] == topics[None, columns]
        best[is_one_topic & ~_are_rates(fields, rows, columns)] = 0.0
        best[rows[:, None] >= columns[None, :]] = 0.0
        most = np.argpartition(best, max(0, best.size - CANDIDATES), axis=None)[-CANDIDATES:]
        found += [
            (float(best[i, j]), int(rows[i]), int(columns[j]))
            for i, j in zip(*np.unravel_index(most, best.shape), strict=True)
            if best[i, j] >= COARSE
        ]
    return [(i, j) for _, i, j in sorted(found, reverse=True)[:CANDIDATES]]


def _are_rates(
    fields: Sequence[Field], rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> Flags:
    """Return where the units of two fields say that one is the rate of the other."""
    units = np.array([each.unit for each in fields])
    rates = np.array([RATES.get(each.unit, "-") for each in fields])
    are_rates: Flags = units[rows, None] == rates[None, columns]
    are_rates |= rates[rows, None] == units[None, columns]
    return are_rates


class _Steps(NamedTuple):
    """What all fields do over some span, in rows of norm 1, or 0 where nothing moves.

    Attributes:
        changes: How they change, shape (fields, k).
        integrals: What they add up to, shape (fields, k).
    """

    changes: NDArray[np.float32]
    integrals: NDArray[np.float32]


def _steps(fields: Sequence[Field]) -> list[_Steps]:
    """Return what all fields do, over each span."""
    start = min(float(each.motion.time_s[0]) for each in fields)
    end = max(float(each.motion.time_s[-1]) for each in fields)
    times = np.linspace(start, end, POINTS)
    parts = [_some_steps(fields[k : k + ROWS], times) for k in range(0, len(fields), ROWS)]
    return [
        _Steps(*(np.concatenate(kind) for kind in zip(*of_span, strict=True)))
        for of_span in zip(*parts, strict=True)
    ]


def _some_steps(fields: Sequence[Field], times: Reals) -> list[_Steps]:
    values = np.array([_binned(each.motion, times) for each in fields])
    both = np.stack([np.diff(values), 0.5 * (values[:, 1:] + values[:, :-1])])
    return [_Steps(*_normalised(both, span)) for span in SPANS]


def _correlations(
    spans: Sequence[_Steps], rows: NDArray[np.int64], first: int
) -> NDArray[np.float32]:
    """Return the largest correlation of some fields with those from one on, of any kind."""
    best = np.zeros((rows.size, spans[0].changes.shape[0] - first), np.float32)
    for changes, integrals in spans:
        for s1, s2 in ((changes, changes), (integrals, changes), (changes, integrals)):
            size = s1.shape[1]
            for lag in LAGS:
                early = slice(max(0, -lag), size - max(0, lag))
                late = slice(max(0, lag), size - max(0, -lag))
                np.maximum(best, np.abs(s1[rows, early] @ s2[first:, late].T), out=best)
    return best


def _binned(motion: Motion, times: Reals) -> Reals:
    """Return the mean of a field about each time, on straight lines where it has no sample."""
    place = np.rint(np.interp(motion.time_s, times, np.arange(times.size))).astype(np.int64)
    counts = np.bincount(place, minlength=times.size)
    sums = np.bincount(place, motion.values, times.size)
    filled = counts > 0
    return np.interp(times, times[filled], sums[filled] / counts[filled])


def _normalised(steps: Reals, span: int) -> NDArray[np.float32]:
    """Return what happens over a span, smoothed over as long, every half of it; rows of norm 1."""
    around = [(0, 0)] * (steps.ndim - 1)
    sums = np.pad(steps - steps.mean(axis=-1, keepdims=True), [*around, (span, span)])
    for _ in range(2):
        total = np.pad(np.cumsum(sums, axis=-1), [*around, (span, 0)])
        sums = total[..., span:] - total[..., :-span]
    sums = sums[..., :: span // 2]
    norm = np.linalg.norm(sums, axis=-1, keepdims=True)
    least = np.abs(steps).max(axis=-1, keepdims=True) * NOTHING
    return np.where(norm > least, sums / np.where(norm > 0.0, norm, 1.0), 0.0).astype(np.float32)
