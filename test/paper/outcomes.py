# SPDX-License-Identifier: Apache-2.0
"""Made-up outcomes of the sweeps for tests: every number chosen, none simulated."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from fuzzy_fusion_ros.paper.methods import METHODS
from fuzzy_fusion_ros.paper.sweep import SWEEPS, Outcome, Point, points_of

SEEDS = range(5)

IAE = {
    "ideal": 0.1,
    "s1": 2.0,
    "s2": 15.0,
    "average": 1.0,
    "no_drift": 0.4,
    "aggregator": 0.15,
    "complete": 0.12,
    "complementary": 0.6,
    "kalman": 0.17,
}
"""IAE of each method in a world where all claims hold and all targets are met, rad s."""

Change = Callable[[Outcome], Outcome]


def unchanged(outcome: Outcome) -> Outcome:
    """Return the outcome as it is."""
    return outcome


def outcomes(
    change: Change = unchanged, points: tuple[Point, ...] = points_of(SWEEPS)
) -> list[Outcome]:
    """Return outcomes of the world where all is well, each changed."""
    return [change(outcome) for outcome in _all_is_well(points)]


def _all_is_well(points: tuple[Point, ...]) -> Iterator[Outcome]:
    for point in points:
        for seed in SEEDS:
            noise = float(np.exp(0.01 * np.random.default_rng(seed).standard_normal()))
            for method in METHODS:
                iae = IAE[method] * noise
                yield Outcome(
                    method=method,
                    point=point,
                    seed=seed,
                    iae=iae,
                    itae=(20.0 if method == "complete" else 25.0) * iae,
                    rmse={"aggregator": 0.007, "complete": 0.005}.get(method, 0.05) * noise,
                    fell=False,
                    swing=(0.6 if method in {"s2", "average"} else 0.01) * noise,
                    unrest=0.01 * noise,
                    signal=0.012,
                    s1_rmse=0.06 * noise,
                    s1_offset=-0.03 * noise,
                    s2_rmse=0.008 * noise,
                    rejected_pushed=0.9 * noise if method == "complete" else float("nan"),
                    rejected_calm=0.05 * noise if method == "complete" else float("nan"),
                )
