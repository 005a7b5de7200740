# SPDX-License-Identifier: Apache-2.0
"""Means, ratios and their intervals over the seeds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from paper.outcomes import IAE, SEEDS, outcomes

from fuzzy_fusion_ros.paper.results import Interval, Results, mean_interval, ratio_interval
from fuzzy_fusion_ros.paper.sweep import NOMINAL


@pytest.mark.parametrize("n", [2, 3, 20])
def test_a_mean_has_students_interval(n: int) -> None:
    from scipy import stats  # which takes most of a second to load

    values = np.random.default_rng(n).normal(3.0, 2.0, n)
    expected = stats.t.interval(0.95, n - 1, np.mean(values), stats.sem(values))
    mean, *interval = mean_interval(values)
    assert mean == pytest.approx(np.mean(values))
    assert interval == pytest.approx(expected)


def test_the_interval_holds_the_true_mean_95_times_of_100() -> None:
    generator = np.random.default_rng(0)
    intervals = [mean_interval(generator.normal(1.0, 3.0, 6)) for _ in range(4000)]
    held = np.mean([low <= 1.0 <= high for _, low, high in intervals])
    assert held == pytest.approx(0.95, abs=0.012)


def test_what_never_varies_has_an_interval_of_no_width() -> None:
    assert mean_interval(np.full(4, 0.5)) == (0.5, 0.5, 0.5)
    assert ratio_interval(np.full(4, 3.0), np.full(4, 2.0)) == pytest.approx((1.5, 1.5, 1.5))


def test_nan_is_not_hidden() -> None:
    assert all(math.isnan(x) for x in mean_interval(np.array([1.0, np.nan, 2.0])))


def test_ratios_are_paired_by_seed() -> None:
    """What all methods have in common in a run is no uncertainty of their ratio."""
    common = np.exp(np.random.default_rng(1).normal(0.0, 1.0, 10))
    own = np.exp(np.random.default_rng(2).normal(0.0, 0.01, 10))
    ratio, low, high = ratio_interval(0.8 * common * own, common)
    assert ratio == pytest.approx(0.8, rel=0.02)
    assert high / low < 1.03


def test_a_ratio_and_its_inverse_have_inverse_intervals() -> None:
    generator = np.random.default_rng(3)
    a, b = np.exp(generator.normal(size=(2, 8)))
    mean, low, high = ratio_interval(a, b)
    assert ratio_interval(b, a) == pytest.approx((1 / mean, 1 / high, 1 / low))


def test_values_are_found_by_method_and_point_in_the_order_of_the_seeds() -> None:
    runs = outcomes()
    results = Results(runs)
    expected = [r.iae for r in runs if r.method == "kalman" and r.point == NOMINAL]
    assert results.values("iae", "kalman").tolist() == expected
    assert len(expected) == len(SEEDS)
    assert results.points[0] == NOMINAL
    assert len(results.points) == 15


def test_a_ratio_of_quantities_is_that_of_their_values() -> None:
    results = Results(outcomes())
    ratio = results.ratio("iae", "complete", "kalman")
    assert isinstance(ratio, Interval)
    assert ratio == pytest.approx([IAE["complete"] / IAE["kalman"]] * 3)
    assert results.mean("iae", "kalman").mean == pytest.approx(IAE["kalman"], rel=0.02)
