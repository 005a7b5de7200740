# SPDX-License-Identifier: Apache-2.0
"""How two sensors are related: by sign, scale and lag, or one as the rate of the other.

Each way in which S2 may follow from S1 is a hypothesis: S1 through a lag, negated or not, or its
integral, or its derivative. Changes of both over the same time are correlated at every lag at once,
by the fast Fourier transform, so that all hypotheses on a thousand points cost milliseconds.

A hypothesis has a cost in natural units of evidence (the logarithm of odds): what it leaves
unexplained, and how unusual it would be. On rich motion the first decides; on a pure sine, where
a sign, a rate and a lag of part of the period look the same, the second.
"""

from __future__ import annotations

import enum
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, root_mean_square
from fuzzy_fusion_ros.checking.motion import Motion

MOST_POINTS = 2**15
"""Points of the grid that motion is compared on; of longer recordings, the liveliest part."""

FEWEST_POINTS = 20
"""With fewer points of the slower sensor a fit of lag, sign and scale means nothing."""

MOST_GAPS = 2
"""Points of the grid per sample of the faster sensor: work grows with samples, not with gaps."""

GRID_STEPS = 4
"""Points of the grid in an interval of the slower sensor, if the faster one has as many."""

GAP = 10.0
"""A step of more than this many median intervals is a gap; nothing is compared across it."""

LONGEST_LAG = 5.0
"""Lags are looked for up to this many seconds or ten intervals of the slower sensor."""

LONGEST_TIME_CONSTANT = 1.0
"""Time constants of S2 up to this many seconds, or two of its intervals: beyond, a low-pass
looks like an integral."""

SHARE_OF_SPAN = 8.0
"""Changes are taken over at most this part of the recording, so that there are several."""

LEAST_MOTION = 0.3
"""Changes over a time in which S2 moves less than this share of its most are not compared: noise
and control loops dominate there."""

MODEL_ERROR = 0.03
"""Share of a sensor's variance that no lag and scale explain even of good sensors."""

WEIGHT = 4.0
"""What is unexplained counts as that of eight independent samples, however many there are: the
errors of the model do not average out."""

NO_FIT = WEIGHT * math.log(1.0 + MODEL_ERROR)
"""Cost of misfit where nothing is explained."""

COSTS = {"negated": 1.0, "s1 rate": 0.7, "s2 rate": 1.0, "known scale": 1.0, "scale": 2.0}
"""What each deviation costs: one recording in three to ten has been set up wrong."""

USUAL_LAG = (0.5, 2.0)
"""A lag costs 1 per this many seconds and this many intervals of the slower sensor."""

LEAD = 3.0
"""S2 ahead of S1 costs this many times as much as a lag: it cannot know the future."""

NEAR_ONE = 1.25
"""A scale within this factor of 1 is taken for 1."""

EXACT = 1.1
"""A scale within this factor of a conversion of units is taken for that."""

CERTAIN = 1.02
"""Within this factor, it is that one,"""

RIVAL = 1.15
"""otherwise it may be one within this factor, as km/h to m/s and feet to metres are."""

LEAST_CORRELATION = 0.05
"""Hypotheses with a lower correlation are dropped."""

POINTS_AT_ONCE = 2**17
"""Points that are transformed in one call: short recordings over all times, long ones over one."""

NOTHING = 1e-12
"""A line whose steps differ by this share of its values or less is straight but for rounding."""

TINY = 1e-200

Spectrum = NDArray[np.complex128]


class Kind(enum.Enum):
    """What the numbers of two sensors are to each other."""

    VALUE = "values of one quantity"
    S1_RATE = "s1 is the rate of s2"
    S2_RATE = "s2 is the rate of s1"


class Conversion(NamedTuple):
    """A factor between two units.

    Attributes:
        factor: How many of the smaller unit the larger one has.
        smaller: Its name.
        larger: Its name.
    """

    factor: float
    smaller: str
    larger: str


# The usual ones first, which are proposed where several may be meant.
CONVERSIONS = (
    Conversion(180.0 / math.pi, "degrees", "radians"),
    Conversion(9.80665, "m/s^2", "g"),
    Conversion(3.6, "km/h", "m/s"),
    Conversion(100.0, "Pa", "hPa (or cm, m)"),
    Conversion(1000.0, "thousandths", "units"),
    Conversion(1.0 / 0.3048, "feet", "metres"),
    Conversion(3600.0 / 1609.344, "mph", "m/s"),
)


FACTORS = [(each, to) for each in CONVERSIONS for to in (each.factor, 1.0 / each.factor)]
"""The conversions either way, with the factor from S1 to S2."""


class Relation(NamedTuple):
    """A hypothesis on how S2 follows from S1, with the lag and the scale that suit it best.

    Attributes:
        kind: What S1 and S2 are to each other.
        sign: 1, or -1 if one of them is negated.
        lag: Delay and time constant of S2 together, seconds; negative if S2 is ahead.
        correlation: Of the changes of S2 with what they should be, 0 to 1.
        scale: Least and largest factor from S1 to S2 that noise in either leaves possible,
            positive; in s or 1/s more for rates.
        chance: Typical correlation at lags that are far off.
        cost: Of the hypothesis, natural units of evidence.
    """

    kind: Kind
    sign: int
    lag: float
    correlation: float
    scale: tuple[float, float]
    chance: float
    cost: float

    @property
    def middle_scale(self) -> float:
        """The factor from S1 to S2 if noise is shared, positive."""
        return math.sqrt(self.scale[0] * self.scale[1])

    @property
    def conversions(self) -> list[tuple[Conversion, float]]:
        """The conversions of units that the scale may be, with the factors from S1 to S2.

        Empty if it is none; more than one only where they are too near to be told apart.
        """
        if _allows(self.scale, 1.0, NEAR_ONE):
            return []
        found = [each for each in FACTORS if _allows(self.scale, each[1], EXACT)]
        nearest = min(found, key=self._distance, default=None)
        if nearest is None or self._distance(nearest) < math.log(CERTAIN):
            return [] if nearest is None else [nearest]
        return [each for each in found if 1.0 / RIVAL < each[1] / nearest[1] < RIVAL]

    @property
    def turned(self) -> Relation:
        """The same relation, of S2 to S1."""
        kinds = {Kind.S1_RATE: Kind.S2_RATE, Kind.S2_RATE: Kind.S1_RATE}
        low, high = self.scale
        return self._replace(
            kind=kinds.get(self.kind, self.kind), lag=-self.lag, scale=(1.0 / high, 1.0 / low)
        )

    def _distance(self, conversion: tuple[Conversion, float]) -> float:
        return abs(math.log(conversion[1] / self.middle_scale))


class Comparison:
    """The motion of two sensors, compared.

    Attributes:
        relations: Every hypothesis with what suits it best, the most credible first; empty if both
            have too few samples together, or one of them never moves.
    """

    def __init__(self, s1: Motion, s2: Motion, most_points: int = MOST_POINTS) -> None:
        """Compare.

        Args:
            s1: Motion of S1.
            s2: Motion of S2, on the same clock.
            most_points: Points to compare; the time that this takes is proportional.
        """
        self.relations: list[Relation] = []
        self._tried: dict[Kind, list[_Tried]] = {}
        self._grid = _grid(s1, s2, most_points)
        if self._grid is not None:
            for each in _hypotheses(self._grid):
                best, self._tried[each.kind] = _best(self._grid, each)
                self.relations += best
            self.relations.sort(key=lambda each: each.cost)

    def lag_of(self, relation: Relation) -> float:
        """Return the lag of a relation by itself, without regard to what is usual.

        Of all times to take changes over, the one that determines the lag best is used: over long
        ones, noise is small but the correlation hardly changes with the lag.

        Args:
            relation: One of these; the lag is looked for near its own.

        Returns:
            Delay and time constant of S2 together, seconds; negative if S2 is ahead.
        """
        if self._grid is None:
            return relation.lag
        found = [
            _Located(relation.lag, math.inf),
            *(_located(self._grid, relation, tried) for tried in self._tried[relation.kind]),
        ]
        return min(found, key=lambda each: each.variance).lag


class _Grid(NamedTuple):
    """Both sensors at even times, and the lags to try.

    Attributes:
        step: Seconds between points.
        s1: Values of S1, shape (n,).
        s2: Values of S2, shape (n,).
        usable: Where neither has a gap between two points, shape (n - 1,).
        slower: Interval of the slower sensor, seconds.
        smoothing: Intervals of the triangles, seconds, that would smooth S1 and S2 as much as the
            lines between samples of the slower one do; 0 for none.
        size: Points of transforms, a power of two.
        frequency: Frequencies of transforms, shape (size // 2 + 1,), Hz.
        spans: Times to take changes over, seconds, shape (p,).
        windows: What makes changes over these from changes between points, transformed, shape
            (p, size // 2 + 1).
        lags: Lags to try, in steps, negative ones included, shape (k,).
        far: Longer lags, up to half of the recording, in steps.
    """

    step: float
    s1: Reals
    s2: Reals
    usable: Flags
    slower: float
    smoothing: tuple[float, float]
    size: int
    frequency: Reals
    spans: Reals
    windows: Reals
    lags: NDArray[np.int64]
    far: NDArray[np.int64]


def _grid(s1: Motion, s2: Motion, most_points: int) -> _Grid | None:
    slower, faster = max(s1.interval, s2.interval), min(s1.interval, s2.interval)
    if not math.isfinite(slower):
        return None
    start = max(s1.time_s[0], s2.time_s[0])
    end = min(s1.time_s[-1], s2.time_s[-1])
    step = max(faster, slower / GRID_STEPS)
    most_points = min(most_points, MOST_GAPS * max(s1.time_s.size, s2.time_s.size))
    if end - start < FEWEST_POINTS * slower:
        return None
    if end - start > most_points * step:
        start = _liveliest(s2, start, end, most_points * step)
        end = start + most_points * step
    times = start + step * np.arange(int((end - start) / step))
    values = _at(s1, times, step), _at(s2, times, step)
    if any(np.std(np.diff(each)) <= NOTHING * np.max(np.abs(each)) for each in values):
        return None
    middles = times[:-1] + 0.5 * step
    size = 1 << (2 * times.size - 1).bit_length()  # padded: one's end is not the other's start
    longest = min(max(LONGEST_LAG, 10.0 * slower), (end - start) / 5.0)
    lags = np.arange(-int(longest / step), int(longest / step) + 1)
    usable = _outside_gaps(s1, middles) & _outside_gaps(s2, middles)
    if np.count_nonzero(usable) * step < FEWEST_POINTS * slower:
        return None
    frequency = np.fft.rfftfreq(size, step).astype(np.float64)
    longest_span = step * times.size / SHARE_OF_SPAN
    octaves = max(0, int(np.log2(longest_span / slower)))
    spans: Reals = slower * 2.0 ** np.arange(1.0 + octaves)
    return _Grid(
        step=step,
        s1=values[0],
        s2=values[1],
        usable=usable,
        slower=slower,
        smoothing=(
            slower if s1.interval < slower / 1.5 else 0.0,
            slower if s2.interval < slower / 1.5 else 0.0,
        ),
        size=size,
        frequency=frequency,
        spans=spans,
        windows=np.sinc(frequency * spans[:, None]) ** 2,
        lags=lags,
        far=np.arange(lags[-1] + 1, times.size // 2),
    )


def _liveliest(motion: Motion, start: float, end: float, span: float) -> float:
    """Return where the part begins in which a sensor changes most, of those that have samples."""
    last = int((end - start) / span) - 1
    parts = np.unique(np.clip((motion.time_s - start) // span, 0, last))
    starts = start + span * parts
    travelled = np.append(0.0, np.cumsum(np.abs(np.diff(motion.values))))
    before, after = (np.interp(each, motion.time_s, travelled) for each in (starts, starts + span))
    return float(starts[np.argmax(after - before)])


def _at(motion: Motion, times: Reals, step: float) -> Reals:
    """Return a sensor at even times: the mean about each, or on lines where it is slower."""
    if motion.interval > step / 1.5:
        return np.interp(times, motion.time_s, motion.values)
    place = np.floor((motion.time_s - times[0]) / step + 0.5).astype(np.int64)
    inside = (place >= 0) & (place < times.size)
    counts = np.bincount(place[inside], minlength=times.size)
    sums = np.bincount(place[inside], motion.values[inside], times.size)
    filled = counts > 0
    return np.interp(times, times[filled], sums[filled] / counts[filled])


def _outside_gaps(motion: Motion, times: Reals) -> Flags:
    steps = np.append(np.diff(motion.time_s), 0.0)
    before = np.clip(np.searchsorted(motion.time_s, times) - 1, 0, steps.size - 1)
    outside: Flags = steps[before] <= GAP * motion.interval
    return outside


class _Hypothesis(NamedTuple):
    """One kind of relation, as transforms of changes that should be proportional.

    Attributes:
        kind: The kind.
        s1: Transform of what S1 says that S2 should do, shape (frequencies,).
        s2: Transform of what S2 does.
    """

    kind: Kind
    s1: Spectrum
    s2: Spectrum


def _hypotheses(grid: _Grid) -> list[_Hypothesis]:
    changes1, integrals1 = _transforms(grid, grid.s1, grid.smoothing[0])
    changes2, integrals2 = _transforms(grid, grid.s2, grid.smoothing[1])
    return [
        _Hypothesis(Kind.VALUE, changes1, changes2),
        _Hypothesis(Kind.S1_RATE, integrals1, changes2),
        _Hypothesis(Kind.S2_RATE, changes1, integrals2),
    ]


def _transforms(grid: _Grid, values: Reals, smoothing: float) -> tuple[Spectrum, Spectrum]:
    """Return the transforms of changes and of integrals from point to point."""
    window = np.sinc(grid.frequency * smoothing) ** 2
    integrals = 0.5 * grid.step * (values[1:] + values[:-1])
    return window * _transform(grid, np.diff(values)), window * _transform(grid, integrals)


def _transform(grid: _Grid, steps: Reals) -> Spectrum:
    """Return the transform of what happens from point to point, without its mean or gaps."""
    kept = np.where(grid.usable, steps - steps[grid.usable].mean(), 0.0)
    found: Spectrum = np.fft.rfft(kept, grid.size)
    return found


class _Tried(NamedTuple):
    """A hypothesis, seen over some times and through several low-passes: a row for each of both.

    Attributes:
        over: Times that changes are taken over, shape (m,), seconds.
        time_constants: Of the low-passes, shape (m,), seconds.
        correlation: At the lags to try, shape (m, k).
        ratios: Size of what S2 does to that of what S1 says it should do, shape (m,).
    """

    over: Reals
    time_constants: Reals
    correlation: Reals
    ratios: Reals

    def delay(self, grid: _Grid) -> Reals:
        """Return what S2 is delayed by at the lags to try, shape (m, k), seconds."""
        return grid.step * grid.lags + self.time_constants[:, None]


def _tried(grid: _Grid, hypothesis: _Hypothesis) -> Iterator[tuple[_Tried, Reals]]:
    """Yield a hypothesis over each time in which S2 moves, through all low-passes.

    With it comes the correlation at every lag, as :func:`numpy.fft.irfft` puts them, shape
    (m, size).
    """
    is_value = hypothesis.kind is Kind.VALUE
    constants = np.array(_time_constants(grid) if is_value else [0.0])
    low_passes = 1.0 / (1.0 + 2j * np.pi * grid.frequency * constants[:, None])
    changes = hypothesis.s2 * grid.windows
    powers = _powers(changes)
    moved = grid.spans * np.sqrt(powers)
    live = np.flatnonzero(moved >= LEAST_MOTION * moved.max())
    at_once = max(1, POINTS_AT_ONCE // (constants.size * grid.size))
    for first in range(0, live.size, at_once):
        k = live[first : first + at_once]
        s1 = (hypothesis.s1 * grid.windows[k])[:, None] * low_passes
        expected = _powers(s1)
        usable = np.minimum(expected.min(axis=1), powers[k]) > TINY
        if not usable.any():
            continue
        k, s1, expected = k[usable], s1[usable], expected[usable]
        products = np.fft.irfft(np.conj(s1) * changes[k, None], grid.size) * (0.5 * grid.size)
        correlation = products / np.sqrt(expected * powers[k, None])[:, :, None]
        every_lag = correlation.reshape(-1, grid.size)
        tried = _Tried(
            over=np.repeat(grid.spans[k], constants.size),
            time_constants=np.tile(constants, k.size),
            correlation=np.take(every_lag, grid.lags, axis=1),
            ratios=np.sqrt(powers[k, None] / expected).ravel(),
        )
        yield tried, every_lag


def _best(grid: _Grid, hypothesis: _Hypothesis) -> tuple[list[Relation], list[_Tried]]:
    """Return a hypothesis with either sign, each with the lag that costs least; and all tried."""
    best: dict[int, Relation] = {}
    seen: list[_Tried] = []
    for tried, every_lag in _tried(grid, hypothesis):
        seen.append(tried)
        correlation, delay = tried.correlation, tried.delay(grid)
        # Both overlap less at long lags, which speaks against these.
        early = tried.time_constants[:, None] - LEAD * grid.step * grid.lags
        lag_cost = np.where(grid.lags >= 0, delay, early) / _usual_lag(grid)
        unexplained = 1.0 - np.square(np.clip(correlation, -1.0, 1.0)) + MODEL_ERROR
        misfit = WEIGHT * np.log(unexplained)
        for sign in (1, -1):
            cost = np.where(sign * correlation > 0.0, misfit, NO_FIT) + lag_cost
            cost += _kind_cost(hypothesis.kind, sign)
            limit = best[sign].cost if sign in best else math.inf
            found = _cheapest(tried, hypothesis.kind, sign, cost, delay, limit)
            if found is not None:
                relation, row = found
                best[sign] = relation._replace(chance=_chance(grid, every_lag[row]))
    return list(best.values()), seen


def _cheapest(
    tried: _Tried, kind: Kind, sign: int, cost: Reals, delay: Reals, limit: float
) -> tuple[Relation, int] | None:
    """Return the cheapest relation of one sign, and its row; None if none costs less than a limit.

    Args:
        tried: The hypothesis.
        kind: Its kind.
        sign: The sign.
        cost: Of misfit, lag, kind and sign, shape (m, k).
        delay: Of S2, seconds, shape (m, k).
        limit: What it must cost less than.
    """
    best = None
    lags = np.argmin(cost, axis=1)
    rows = np.arange(lags.size)
    for m in np.argsort(cost[rows, lags], kind="stable"):
        k = lags[m]
        if cost[m, k] >= limit:
            break  # the scale can only add to it
        r, ratio = min(sign * float(tried.correlation[m, k]), 1.0), float(tried.ratios[m])
        if r <= LEAST_CORRELATION:
            continue
        scale = (r * ratio, ratio / r)
        total = float(cost[m, k]) + _scale_cost(scale)
        if total < limit:
            lag = float(delay[m, k])
            best = Relation(kind, sign, lag, r, scale, chance=math.nan, cost=total), int(m)
            limit = total
    return best


def _chance(grid: _Grid, correlation: Reals) -> float:
    """Return the typical correlation at lags that are far off."""
    far = np.append(grid.far, -grid.far)
    overlap = 1.0 - np.abs(far) / grid.s1.size
    return root_mean_square(correlation[far] / overlap) if far.size else 1.0


def _time_constants(grid: _Grid) -> list[float]:
    longest = max(LONGEST_TIME_CONSTANT, 2.0 * grid.slower)
    octaves = np.arange(0.0, np.log2(longest / (0.5 * grid.slower)) + 0.25, 0.5)
    return [0.0, *(0.5 * grid.slower * 2.0**octaves)]


class _Located(NamedTuple):
    """Where a lag is.

    Attributes:
        lag: Seconds.
        variance: Of it, but for a factor that is the same over all times.
    """

    lag: float
    variance: float


def _located(grid: _Grid, relation: Relation, tried: _Tried) -> _Located:
    """Return the lag at the top of the correlation, on a parabola through it."""
    near, lags = relation.sign * tried.correlation, tried.delay(grid)
    first = np.where(tried.time_constants > 0.0, 0, grid.lags[0] + 1)[:, None]
    usable = (grid.lags >= first) & (grid.lags < grid.lags[-1])
    usable &= np.abs(lags - relation.lag) <= _usual_lag(grid)
    rows = np.flatnonzero(usable.any(axis=1))
    k = np.argmax(np.where(usable, near, -np.inf), axis=1)[rows]
    before, top, after = (near[rows, k + off] for off in (-1, 0, 1))
    bend = 2.0 * top - before - after
    bent = bend > 0.0
    if not bent.any():
        return _Located(relation.lag, math.inf)
    rows, k, before, top, after, bend = (each[bent] for each in (rows, k, before, top, after, bend))
    found = lags[rows, k] + 0.5 * grid.step * np.clip((after - before) / bend, -1.0, 1.0)
    variances = tried.over[rows] * (1.0 - np.square(np.minimum(top, 1.0)) + MODEL_ERROR) / bend
    best = int(np.argmin(variances))
    return _Located(float(found[best]), float(variances[best]))


def _usual_lag(grid: _Grid) -> float:
    return USUAL_LAG[0] + USUAL_LAG[1] * grid.slower


def _kind_cost(kind: Kind, sign: int) -> float:
    """Return what a kind and a sign cost, however well they fit."""
    rate = {Kind.VALUE: 0.0, Kind.S1_RATE: COSTS["s1 rate"], Kind.S2_RATE: COSTS["s2 rate"]}
    return rate[kind] + (COSTS["negated"] if sign < 0 else 0.0)


def _scale_cost(scale: tuple[float, float]) -> float:
    """Return what a scale costs: nothing if it may be 1, less if it is one between units."""
    if _allows(scale, 1.0, NEAR_ONE):
        return 0.0
    is_known = any(_allows(scale, factor, EXACT) for _, factor in FACTORS)
    return COSTS["known scale" if is_known else "scale"]


def _allows(scale: tuple[float, float], factor: float, off: float) -> bool:
    """Return whether a scale may be a factor, or off by another one from it."""
    return scale[0] / off <= factor <= scale[1] * off


def _powers(spectra: Spectrum) -> Reals:
    """Return the power of each of some spectra, shape (..., frequencies)."""
    powers: Reals = np.square(np.linalg.norm(spectra, axis=-1))
    return powers
