# SPDX-License-Identifier: Apache-2.0
"""Allan's statistic against numpy over the whole series."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fuzzy_fusion_ros.self_tuning.allan import (
    SIGMA_OVER_USUAL,
    Octaves,
    Reals,
    averaging_time,
    counted,
    no_octaves,
    root_mean_square,
    usual,
    vertex,
)

LONG = 1 << 20


def of(values: Reals, octaves: int, memory: int = LONG) -> Octaves:
    """The statistic of a series, shape (n, k)."""
    kept = no_octaves(octaves, values.shape[1])
    for row in values:
        kept = counted(kept, row, False, memory)
    return kept


def differences(values: Reals, octave: int) -> Reals:
    """Differences of successive means over ``2 ** octave`` samples, in pairs."""
    n = 2**octave
    means = values[: values.shape[0] // n * n].reshape(-1, n, values.shape[1]).mean(axis=1)
    pairs = means[: means.shape[0] // 2 * 2].reshape(-1, 2, values.shape[1])
    return np.abs(pairs[:, 1] - pairs[:, 0])


def test_it_is_numpys_over_the_whole_series() -> None:
    values = np.random.default_rng(1).standard_normal((301, 3)).cumsum(axis=0)
    kept = of(values, 6)
    for octave in range(6):
        apart = differences(values, octave)
        assert usual(kept)[octave] == pytest.approx(np.sqrt(apart).mean(axis=0) ** 2)
        assert root_mean_square(kept)[octave] == pytest.approx(np.sqrt((apart**2).mean(axis=0)))


def test_octaves_of_few_differences_say_nothing() -> None:
    assert usual(of(np.zeros((31, 2)), 6)).shape == (2, 2)
    assert usual(no_octaves(6, 2)).shape == (0, 2)


def test_means_do_not_reach_over_a_gap() -> None:
    kept = counted(no_octaves(2, 1), np.array([0.0]), False, LONG)
    kept = counted(kept, np.array([1000.0]), True, LONG)
    kept = counted(kept, np.array([1001.0]), False, LONG)
    assert (kept.counts[0], kept.squares[0][0]) == (1, 1.0)


def test_old_differences_are_forgotten() -> None:
    values = np.concatenate([np.tile([[0.0], [9.0]], (500, 1)), np.zeros((4000, 1))])
    assert root_mean_square(of(values, 3, memory=64))[0, 0] < 1e-4
    assert root_mean_square(of(values, 3))[0, 0] > 1.0


def test_the_usual_difference_of_white_noise_is_its_standard_deviation() -> None:
    noise = np.random.default_rng(2).standard_normal((40_000, 1)) * 0.3
    assert usual(of(noise, 1))[0, 0] * SIGMA_OVER_USUAL == pytest.approx(0.3, rel=0.03)


def test_noise_on_a_random_walk_is_averaged_as_long_as_a_kalman_filter_does() -> None:
    generator = np.random.default_rng(3)
    noise, walk, interval = 1.0, 0.05, 0.1
    steps = generator.standard_normal(60_000) * walk * math.sqrt(interval)
    values = steps.cumsum() + noise * generator.standard_normal(steps.size)
    size = root_mean_square(of(values[:, None], 12))[:, 0]
    best = noise * math.sqrt(interval) / walk
    assert averaging_time(size, interval) == pytest.approx(best, rel=0.35)


@pytest.mark.parametrize("size", [[], [1.0], [1.0, 2.0, 4.0]])
def test_what_moves_more_than_it_is_noisy_is_not_averaged(size: list[float]) -> None:
    assert averaging_time(np.array(size), 0.1) == 0.0


@pytest.mark.parametrize(
    ("curve", "lowest", "place"),
    [
        ([4.0, 1.0, 0.0, 1.0], 2, 0.0),
        ([1.0, 0.0, 0.0, 1.0], 1, 0.5),
        ([0.0, 0.0, 0.0], 1, 0.0),
        ([3.0, 1.0, 0.5], 1, 0.5),
        ([1.0, 2.0], 0, 0.0),
    ],
)
def test_a_parabola_finds_the_lowest_point_between_three(
    curve: list[float], lowest: int, place: float
) -> None:
    assert vertex(np.array(curve), lowest) == pytest.approx(place)
