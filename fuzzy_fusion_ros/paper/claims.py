# SPDX-License-Identifier: Apache-2.0
"""The paper's claims, each with the number that decides it (paper § 4).

A claim holds when the whole 95 % interval lies on its side of the bound and, where it is about a
sweep, does so at every point. *Fusion* is the complete algorithm.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fuzzy_fusion_ros.paper.checks import (
    SYMBOLS,
    CheckedClaim,
    Measured,
    above,
    below,
    place,
    ratios,
)
from fuzzy_fusion_ros.paper.results import Results, mean_interval, ratio_interval
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Point, sweep_points
from fuzzy_fusion_ros.simulation.scenario import Scenario

FIGURES = {"tau2": (18, 19), "sigma1": (20, 21), "bias1": (22, 23)}
"""Which figures show IAE and ITAE over each sweep."""

RIVALS = ("s2", "average")
"""What the paper's sweeps compare the fusion with."""

INITIAL_ANGLE = Scenario().plant.initial_angle
"""A swing as large as this to both sides is an oscillation, rad: nothing has decayed."""

HIGH = 2.0
"""A deviation is high at this multiple of the ideal sensor's and above."""

STEADY = 0.02
"""Within this, a pendulum is balanced well, rad: a tenth of its initial angle."""

SWING = "swing to both sides in the last 10 s, rad"


def claims(results: Results, figures: Sequence[int]) -> list[CheckedClaim]:
    """Return the claims about the given figures, in the order of the figures.

    Args:
        results: Runs of all methods; an incomplete sweep is ignored.
        figures: Numbers of figures.
    """
    found = []
    if NOMINAL in results.points:
        found += [*_about_responses(results), *_about_estimates(results)]
    for swept in FIGURES:
        if set(sweep_points(swept)) <= set(results.points):
            found += _about_sweep(results, swept)
    return sorted((f for f in found if f.figure in figures), key=lambda f: f.figure)


def _about_responses(results: Results) -> list[CheckedClaim]:
    return [
        above(
            7,
            "S1 alone deviates highly from the zero line",
            Measured("IAE of S1 ÷ ideal sensor", results.ratio("iae", "s1", "ideal")),
            HIGH,
        ),
        above(
            8,
            "S2 alone oscillates",
            Measured(SWING, results.mean("swing", "s2")),
            INITIAL_ANGLE,
        ),
        above(
            9,
            "the plain average is not enough",
            Measured("IAE of average ÷ aggregator", results.ratio("iae", "average", "aggregator")),
            1.0,
        ),
        above(
            10,
            "without drift the response is worse than with",
            Measured(
                "IAE of no drift ÷ aggregator", results.ratio("iae", "no_drift", "aggregator")
            ),
            1.0,
        ),
        below(
            11,
            "the aggregator balances well without predictor",
            Measured(
                "largest angle from 5 s to the push, rad", results.mean("unrest", "aggregator")
            ),
            STEADY,
        ),
    ]


def _about_estimates(results: Results) -> list[CheckedClaim]:
    errors = results.values("rmse", "aggregator") / results.values("signal", "aggregator")
    return [
        below(
            14,
            "S1 is off to the negative side on average",
            Measured("mean of S1 − signal, rad", results.mean("s1_offset", "aggregator")),
            0.0,
        ),
        above(
            15,
            "the estimate follows the signal",
            Measured("share of the signal's mean square explained", mean_interval(1 - errors**2)),
            0.5,
        ),
        below(
            16,
            "the predictor makes the estimate more accurate",
            Measured(
                "RMS error of complete ÷ aggregator",
                results.ratio("rmse", "complete", "aggregator"),
            ),
            1.0,
        ),
        below(
            16,
            "the predictor makes the response better",
            Measured(
                "IAE of complete ÷ aggregator", results.ratio("iae", "complete", "aggregator")
            ),
            1.0,
        ),
        above(
            17,
            "the gate ignores the predictor during the disturbance",
            Measured(
                "share of predictions rejected from the push to 0.4 s after",
                results.mean("rejected_pushed", "complete"),
            ),
            0.5,
        ),
        below(
            17,
            "the gate ignores the predictor only temporarily",
            Measured(
                "share of predictions rejected from 5 s to the push",
                results.mean("rejected_calm", "complete"),
            ),
            0.5,
        ),
    ]


def _about_sweep(results: Results, swept: str) -> list[CheckedClaim]:
    symbol = SYMBOLS[swept][0]
    points = sweep_points(swept)
    found = []
    for quantity, figure in zip(("iae", "itae"), FIGURES[swept], strict=True):
        worst = max(
            ratios(results, quantity, "complete", RIVALS, points),
            key=lambda measured: measured.interval.high,
        )
        claim = (
            f"of S2, average and fusion, fusion has the least {quantity.upper()} at every {symbol}"
        )
        found.append(below(figure, claim, worst, 1.0))
    found.append(
        above(FIGURES[swept][1], "ITAE shows it more clearly than IAE", _gain(results, points), 1.0)
    )
    if swept == "tau2":
        stillest = min(
            (_swing(results, rival, point) for rival in RIVALS for point in points),
            key=lambda measured: measured.interval.low,
        )
        claim = f"S2 alone and the average oscillate at every {symbol}"
        found.append(above(FIGURES[swept][0], claim, stillest, INITIAL_ANGLE))
    return found


def _gain(results: Results, points: Sequence[Point]) -> Measured:
    """Return how much larger fusion's lead is in ITAE than in IAE, on average over a sweep."""
    gains = {}
    for point in points:
        for rival in RIVALS:
            itae, iae = (
                results.values(quantity, rival, point) / results.values(quantity, "complete", point)
                for quantity in ("itae", "iae")
            )
            gains[f"{rival}, {place(point)}"] = itae / iae
    each = np.array(list(gains.values()))
    overall = np.exp(np.mean(np.log(each), axis=0))
    least = min(gains, key=lambda where: float(np.mean(gains[where])))
    return Measured(
        "rival ÷ complete in ITAE ÷ in IAE, mean of the sweep",
        ratio_interval(overall, np.ones_like(overall)),
        f"least: {np.mean(gains[least]):.2g} at {least}",
    )


def _swing(results: Results, method: str, point: Point) -> Measured:
    swing = results.mean("swing", method, point)
    return Measured(SWING, swing, f"{method}, {place(point)}")
