# SPDX-License-Identifier: Apache-2.0
"""Targets of our own for the defaults, beyond the paper's claims.

A target is met if the mean over the seeds meets it; the interval is shown with it.
"""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.paper.checks import (
    CheckedClaim,
    Measured,
    mean_at_most,
    ratios,
    stated,
)
from fuzzy_fusion_ros.paper.claims import FIGURES
from fuzzy_fusion_ros.paper.results import Results
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Point, sweep_points

OTHERS = ("s1", "s2", "average", "complementary")
"""What a user without a model would use."""

AHEAD_OF_KALMAN = (
    NOMINAL._replace(tau2=0.05),
    NOMINAL._replace(tau2=0.10),
    NOMINAL._replace(bias1=0.0),
)
"""Where fusion should be ahead even of a filter that knows the nominal plant and sensors."""


def targets(results: Results, figures: Sequence[int]) -> list[CheckedClaim]:
    """Return the targets about the given figures, in the order of the figures.

    Args:
        results: Runs of all methods; an incomplete sweep is ignored.
        figures: Numbers of figures.
    """
    found = _at_nominal(results) if NOMINAL in results.points else []
    for swept in FIGURES:
        if set(sweep_points(swept)) <= set(results.points):
            found += _over_sweep(results, swept)
    return sorted((f for f in found if f.figure in figures), key=lambda f: f.figure)


def _at_nominal(results: Results) -> list[CheckedClaim]:
    iae = Measured("IAE of aggregator, rad s", results.mean("iae", "aggregator"))
    rmse = Measured("RMS error of aggregator, rad", results.mean("rmse", "aggregator"))
    return [
        mean_at_most(11, "the aggregator's IAE is small", iae, 0.19),
        mean_at_most(
            11,
            "the aggregator's IAE is far below the average's",
            _nominal_ratio(results, "iae", "aggregator", "average"),
            0.18,
        ),
        mean_at_most(15, "the aggregator's error is small", rmse, 0.0080),
        mean_at_most(
            16,
            "the predictor lowers the IAE",
            _nominal_ratio(results, "iae", "complete", "aggregator"),
            1.0,
        ),
        mean_at_most(
            16,
            "the predictor lowers the error by a quarter",
            _nominal_ratio(results, "rmse", "complete", "aggregator"),
            0.75,
        ),
        mean_at_most(
            16,
            "fusion is near a Kalman filter that knows everything",
            _nominal_ratio(results, "iae", "complete", "kalman"),
            1.10,
        ),
    ]


def _over_sweep(results: Results, swept: str) -> list[CheckedClaim]:
    figure = FIGURES[swept][0]
    points = sweep_points(swept)
    return [
        mean_at_most(
            figure,
            "the predictor costs nothing at any point",
            _worst(ratios(results, "iae", "complete", ["aggregator"], points)),
            1.05,
        ),
        mean_at_most(
            figure,
            "fusion is ahead of all without a model, at every point",
            _worst(ratios(results, "iae", "complete", OTHERS, points)),
            1.0,
        ),
        *(_against_kalman(results, figure, point) for point in points if point != NOMINAL),
    ]


def _against_kalman(results: Results, figure: int, point: Point) -> CheckedClaim:
    (measured,) = ratios(results, "iae", "complete", ["kalman"], [point])
    if point in AHEAD_OF_KALMAN:
        return mean_at_most(figure, "fusion is ahead of that Kalman filter", measured, 1.0)
    return stated(figure, "distance to that Kalman filter", measured)


def _nominal_ratio(results: Results, quantity: str, method: str, other: str) -> Measured:
    (measured,) = ratios(results, quantity, method, [other], [NOMINAL])
    return measured._replace(where="")


def _worst(measured: Sequence[Measured]) -> Measured:
    return max(measured, key=lambda each: each.interval.mean)
