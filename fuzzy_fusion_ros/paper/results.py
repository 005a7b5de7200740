# SPDX-License-Identifier: Apache-2.0
"""Outcomes of the sweeps by method and point, and confidence intervals over the seeds."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Outcome, Point

CONFIDENCE = 0.95


class Interval(NamedTuple):
    """A mean and its 95 % confidence interval."""

    mean: float
    low: float
    high: float


class Results:
    """Outcomes by method and point, one value per seed.

    Attributes:
        points: The points that were run, in order.
    """

    def __init__(self, outcomes: Iterable[Outcome]) -> None:
        self._runs: dict[tuple[str, Point], list[Outcome]] = {}
        for outcome in outcomes:
            self._runs.setdefault((outcome.method, outcome.point), []).append(outcome)
        self.points = tuple(dict.fromkeys(point for _, point in self._runs))

    def values(self, quantity: str, method: str, point: Point = NOMINAL) -> Reals:
        """Return a quantity of :class:`Outcome` in every run, shape (seeds,), in their order."""
        return np.array([getattr(run, quantity) for run in self._runs[method, point]], float)

    def mean(self, quantity: str, method: str, point: Point = NOMINAL) -> Interval:
        """Return the mean of a quantity over the seeds."""
        return mean_interval(self.values(quantity, method, point))

    def ratio(self, quantity: str, method: str, other: str, point: Point = NOMINAL) -> Interval:
        """Return ``method``'s quantity over ``other``'s, paired by seed."""
        mine = self.values(quantity, method, point)
        return ratio_interval(mine, self.values(quantity, other, point))


def mean_interval(values: Reals) -> Interval:
    """Return the mean of independent values with Student's interval.

    Args:
        values: Two or more values, shape (n,); NaN among them makes everything NaN.
    """
    mean = float(np.mean(values))
    quantile = float(stdtrit(values.size - 1, 0.5 + 0.5 * CONFIDENCE))
    half = quantile * float(np.std(values, ddof=1)) / float(np.sqrt(values.size))
    return Interval(mean, mean - half, mean + half)


def ratio_interval(values: Reals, others: Reals) -> Interval:
    """Return the geometric mean of paired ratios with Student's interval of its logarithm.

    Args:
        values: Positive values, shape (n,).
        others: Their partners, positive, shape (n,).
    """
    return Interval(*(float(x) for x in np.exp(mean_interval(np.log(values / others)))))
