# SPDX-License-Identifier: Apache-2.0
"""The optimiser finds minima, repeats itself to the last digit, and ends when told to."""

from __future__ import annotations

import threading

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.tuning.search import LEAST_SQUARES_STEPS, Pool, Search, minimise

HILL = Search(
    lambda x: float(np.sum(np.square(x - 0.7))), np.array([0.1, 0.9, 0.5]), 0.1, 2000, (4, 2)
)


def nothing(done: int, of: int) -> None:
    """Tell nobody how far it is."""


def test_it_finds_a_minimum() -> None:
    assert minimise(HILL).point == pytest.approx([0.7] * 3, abs=0.01)


def test_it_stays_in_the_cube() -> None:
    minimum = minimise(HILL._replace(cost=lambda x: -float(np.sum(x))))
    assert minimum.point == pytest.approx([1.0] * 3, abs=1e-3)
    assert (minimum.point <= 1.0).all()


@pytest.mark.parametrize("evaluations", [1, 39, 40, 100])
def test_it_is_never_worse_than_its_start_nor_asks_too_often(evaluations: int) -> None:
    asked: list[Reals] = []

    def cost(point: Reals) -> float:
        asked.append(point)
        return float(np.sum(np.square(point - HILL.start)))

    minimum = minimise(HILL._replace(cost=cost, evaluations=evaluations))
    assert minimum.cost < 1e-30
    assert len(asked) <= evaluations


@pytest.mark.parametrize("evaluations", [1, 40])
def test_least_squares_end_a_search(evaluations: int) -> None:
    target = np.array([0.3, 0.6, 0.45])

    def residuals(point: Reals) -> Reals:
        return np.concatenate([point - target, [0.1]])

    search = HILL._replace(
        cost=lambda x: float(np.sqrt(np.mean(np.square(residuals(x))))),
        evaluations=evaluations,
        residuals=residuals,
    )
    assert minimise(search).point == pytest.approx(target, abs=1e-4)
    assert search.evolves == (evaluations == 40)
    assert search.planned == evaluations + (2 if search.evolves else 1) * LEAST_SQUARES_STEPS * 4


def test_threads_do_not_change_the_answers() -> None:
    searches = [HILL._replace(seed=(k,), evaluations=200) for k in range(6)]
    alone, many = [], []
    for threads, answers in ((1, alone), (5, many)):
        with Pool(threads, nothing, 1200) as pool:
            answers += [each.point.tolist() for each in pool.run(searches)]
    assert alone == many
    assert len({tuple(each) for each in alone}) == 6


def test_it_tells_how_far_it_is() -> None:
    told: list[tuple[int, int]] = []
    flat = HILL._replace(cost=lambda x: 1.0, evaluations=400)
    with Pool(2, lambda done, of: told.append((done, of)), 800) as pool:
        pool.run([flat, flat])
    assert told[-1] == (800, 800)
    assert [done for done, _ in told] == sorted(done for done, _ in told)


def test_an_error_ends_all_searches() -> None:
    started = threading.Event()

    def endless(point: Reals) -> float:
        started.set()
        return float(np.random.default_rng().random())

    def broken(point: Reals) -> float:
        started.wait()
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError), Pool(2, nothing, 1) as pool:
        pool.run([HILL._replace(cost=broken), HILL._replace(cost=endless, evaluations=10**9)])
