# SPDX-License-Identifier: Apache-2.0
"""What an estimate is scored by: each a function with a name and a unit.

All take errors (estimate minus truth) and their times. Statistics with an unqualified name are
over the magnitude of the error, as users of evo know them; ``bias`` and ``std`` keep the sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import (
    Reals,
    integral_absolute_error,
    integral_time_absolute_error,
    root_mean_square,
)
from fuzzy_fusion_ros.parameters.errors import FusionError

LAGS = 200
"""Number of shifts tried each way when looking for the lag."""

_MOST_POINTS = 200_000


class ScoreError(FusionError):
    """There is nothing to score, or scores cannot be compared."""


UNSURE: Reals = np.empty(0)
"""No standard deviation at all."""


@dataclass(frozen=True, eq=False)
class Matched:
    """An estimate and the truth, for which every metric is defined.

    Attributes:
        time_s: Times, rising, shape (n,), seconds.
        estimate: The estimate, finite, shape (n,).
        truth: The truth, finite, shape (n,).
        deviation: Standard deviation of the estimate as the filter has it, more than 0, shape
            (n,); empty where it has none, and then not for :data:`SURENESS`.

    Raises:
        ScoreError: There is no sample, shapes differ, times do not rise, or a number is not finite.
    """

    time_s: Reals
    estimate: Reals
    truth: Reals
    deviation: Reals = field(default_factory=lambda: UNSURE)

    def __post_init__(self) -> None:
        arrays = [self.time_s, self.estimate, self.truth]
        arrays += [] if self.deviation is UNSURE else [self.deviation]
        shapes = {array.shape for array in arrays}
        if len(shapes) != 1 or self.time_s.ndim != 1:
            raise ScoreError(f"got arrays of shapes {sorted(shapes)}, expected three of one (n,)")
        if self.time_s.size == 0:
            raise ScoreError("got no sample, expected at least one")
        if not all(np.isfinite(array).all() for array in arrays):
            raise ScoreError("got a number that is not finite, expected finite ones only")
        if not (np.diff(self.time_s) > 0.0).all():
            raise ScoreError("got times that do not increase, expected increasing ones")

    @cached_property
    def error(self) -> Reals:
        """Estimate minus truth, shape (n,)."""
        return self.estimate - self.truth


class Metric(NamedTuple):
    """A measure of how good an estimate is; lower is better, except for ``bias`` and ``lag``.

    Attributes:
        name: Short, as in tables and JSON.
        unit: Built from that of the signal, which is written ``u``.
        function: What computes it.
        text: Its meaning.
    """

    name: str
    unit: str
    function: Callable[[Matched], float]
    text: str

    def unit_for(self, signal: str) -> str:
        """Return the unit for a signal of that unit."""
        compound = f"({signal})" if "/" in signal and self.unit != "u" else signal
        return self.unit.replace("u", compound)


def rmse(matched: Matched) -> float:
    """Return the root of the mean squared error."""
    return root_mean_square(matched.error)


def mae(matched: Matched) -> float:
    """Return the mean magnitude of the error; evo calls it mean."""
    return float(np.mean(np.abs(matched.error)))


def median(matched: Matched) -> float:
    """Return the median magnitude of the error."""
    return float(np.median(np.abs(matched.error)))


def std(matched: Matched) -> float:
    """Return the standard deviation of the error."""
    return float(np.std(matched.error))


def smallest(matched: Matched) -> float:
    """Return the smallest magnitude of the error."""
    return float(np.min(np.abs(matched.error)))


def largest(matched: Matched) -> float:
    """Return the largest magnitude of the error."""
    return float(np.max(np.abs(matched.error)))


def sse(matched: Matched) -> float:
    """Return the sum of the squared errors."""
    return float(np.sum(np.square(matched.error)))


def bias(matched: Matched) -> float:
    """Return the mean error."""
    return float(np.mean(matched.error))


def iae(matched: Matched) -> float:
    """Return the time integral of the error's magnitude; each sample holds until the next."""
    return integral_absolute_error(matched.time_s, matched.error)


def itae(matched: Matched) -> float:
    """Return that integral, weighted by the time since the first sample."""
    return integral_time_absolute_error(matched.time_s, matched.error)


def lag(matched: Matched) -> float:
    """Return how late the estimate is, negative if early: the shift at which it fits best.

    The fit is of both about their means, on a grid of the median step; 0 where a series does not
    move. At :func:`longest_lag`, either way, it is at least that long. Gaps longer than ``LAGS``
    steps are taken as that long.
    """
    if matched.time_s.size < 5 or np.ptp(matched.estimate) == 0.0 or np.ptp(matched.truth) == 0.0:
        return 0.0
    even = _even(matched.time_s)
    middle = np.mean(matched.truth)
    estimate = np.interp(even.grid, even.time_s, matched.estimate - middle)
    truth = np.interp(even.grid, even.time_s, matched.truth - middle)
    best, misfits = _best_shift(estimate, truth[even.reach : truth.size - even.reach])
    return (best - even.reach + _vertex(misfits)) * even.step


def longest_lag(time_s: Reals) -> float:
    """Return the longest lag that :func:`lag` tries, either way, seconds.

    It is ``LAGS`` median steps, but at most a quarter of the span.

    Args:
        time_s: Matched times, shape (n,), seconds.
    """
    if time_s.size < 5:
        return 0.0
    even = _even(time_s)
    return even.reach * even.step


class _Even(NamedTuple):
    """Even times over matched ones.

    Attributes:
        time_s: The matched ones, long gaps shortened, shape (n,), seconds.
        grid: The even ones, shape (m,), seconds.
        step: Between two of them, seconds.
        reach: The longest shift, in steps.
    """

    time_s: Reals
    grid: Reals
    step: float
    reach: int


def _even(time_s: Reals) -> _Even:
    steps = np.diff(time_s)
    usual = float(np.median(steps))
    excess = np.concatenate([[0.0], np.cumsum(np.maximum(steps - LAGS * usual, 0.0))])
    time_s = time_s - excess
    step = max(usual, float(time_s[-1] - time_s[0]) / _MOST_POINTS)
    grid = np.arange(time_s[0], time_s[-1], step)
    return _Even(time_s, grid, step, min(LAGS, grid.size // 4))


def _best_shift(estimate: Reals, truth: Reals) -> tuple[int, Reals]:
    """Return the shift at which a part of an estimate fits a truth best, about their means.

    Returns:
        The shift, and the variance of the misfit there between those at its neighbours.
    """
    n = truth.size
    windows = np.lib.stride_tricks.sliding_window_view(estimate, n)
    sums = _sliding_sums(estimate, n) - np.sum(truth)
    squares = _sliding_sums(np.square(estimate), n)
    products = np.array([window @ truth for window in windows])
    best = int(np.argmin(squares - 2.0 * products - np.square(sums) / n))
    near = windows[max(best - 1, 0) : best + 2]
    return best, np.array([np.var(window - truth) for window in near])


def _sliding_sums(values: Reals, n: int) -> Reals:
    """Return the sum of each ``n`` neighbours."""
    sums = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(sums[n:] - sums[:-n])


def _vertex(values: Reals) -> float:
    """Return where between its neighbours the parabola through a minimum has its own."""
    if values.size < 3:
        return 0.0
    before, here, after = values
    curvature = before - 2.0 * here + after
    return float(0.5 * (before - after) / curvature) if curvature > 0.0 else 0.0


METRICS: Mapping[str, Metric] = MappingProxyType(
    {
        metric.name: metric
        for metric in (
            Metric("rmse", "u", rmse, "root mean square error"),
            Metric("mae", "u", mae, "mean magnitude of the error (evo: mean)"),
            Metric("median", "u", median, "median magnitude of the error"),
            Metric("std", "u", std, "standard deviation of the error"),
            Metric("min", "u", smallest, "smallest magnitude of the error"),
            Metric("max", "u", largest, "largest magnitude of the error"),
            Metric("sse", "u^2", sse, "sum of squared errors"),
            Metric("bias", "u", bias, "mean error"),
            Metric("iae", "u s", iae, "time integral of the error's magnitude"),
            Metric("itae", "u s^2", itae, "the same, weighted by time"),
            Metric("lag", "s", lag, "how late the estimate is"),
        )
    }
)


def within_1sd(matched: Matched) -> float:
    """Return the share of errors within one standard deviation: 0.68 if that is right."""
    return _within(matched, 1.0)


def within_2sd(matched: Matched) -> float:
    """Return the share of errors within two standard deviations: 0.95 if they are right."""
    return _within(matched, 2.0)


def nll(matched: Matched) -> float:
    """Return the mean negative log-likelihood of the errors, normal with those deviations."""
    deviation = matched.deviation
    scaled = matched.error / deviation
    return float(np.mean(np.log(deviation) + 0.5 * scaled**2) + 0.5 * np.log(2.0 * np.pi))


def _within(matched: Matched, factor: float) -> float:
    return float(np.mean(np.abs(matched.error) <= factor * matched.deviation))


SURENESS: Mapping[str, Metric] = MappingProxyType(
    {
        metric.name: metric
        for metric in (
            Metric("within_1sd", "", within_1sd, "share of errors within 1 standard deviation"),
            Metric("within_2sd", "", within_2sd, "share of errors within 2"),
            Metric("nll", "", nll, "mean negative log-likelihood of the errors"),
        )
    }
)
"""What says whether a filter's own standard deviation is right."""

REPORTED = ("rmse", "mae", "iae", "itae", "max", "bias")
"""Those in the JSON of ``score``."""
