# SPDX-License-Identifier: Apache-2.0
"""How samples come: one by one, or in bursts of two or more."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.bursts import bursts_of

EVEN: Reals = 0.1 * np.arange(1200)


def bursts(size: int, apart: float, period: float) -> Reals:
    """Return times of 200 bursts."""
    found: Reals = np.add.outer(period * np.arange(200), apart * np.arange(size)).ravel()
    return found


@pytest.mark.parametrize(
    ("size", "apart", "period"),
    [
        (2, 0.005, 0.5),
        (2, 0.04, 0.5),
        (2, 0.005, 0.1),  # two publishers come like that, too
        (3, 0.04, 0.5),
        (5, 0.02, 0.5),
        (5, 1e-6, 0.5),
        (10, 1e-5, 0.01),  # a buffer that is emptied a hundred times a second
        (10, 0.02, 2.2),
        (15, 0.002, 1.5),
    ],
)
def test_bursts(size: int, apart: float, period: float) -> None:
    times = bursts(size, apart, period)
    for some in (times, times[1:], np.append(times, times + 1e4)):
        found = bursts_of(some)
        assert found.size == pytest.approx(size, rel=0.01)
        assert found.period == pytest.approx(period - (size - 1) * apart)
        assert found.within == pytest.approx(apart)
        assert found.interval == pytest.approx(period / size, rel=0.01)
        assert np.array_equal(found.between, np.diff(some) > 2.0 * apart)


def test_pairs_that_come_at_odd_times_and_get_lost() -> None:
    rng = np.random.default_rng(1)
    times = bursts(2, 0.02, 0.5) + np.repeat(rng.uniform(-0.1, 0.1, 200), 2)
    found = bursts_of(times[rng.uniform(size=400) > 0.15])
    assert found.interval == pytest.approx(0.25 / 0.85, rel=0.05)


RNG = np.random.default_rng(3)


@pytest.mark.parametrize(
    "times",
    [
        EVEN,
        EVEN[RNG.uniform(size=1200) > 0.5],
        EVEN + 0.04 * RNG.uniform(-1.0, 1.0, 1200),
        np.cumsum(RNG.exponential(0.1, 1200)),
        np.append(0.002 * np.arange(1000), 2.0 + np.arange(100)),  # a rate that changes
        np.append(0.02 * np.arange(3000), 3600.0 + 0.02 * np.arange(3000)),
        0.02 * np.arange(1000) + 2.0 * (np.arange(1000) // 50),  # seen now and then
        bursts(2, 0.1, 0.5),  # two of five
        bursts(2, 0.005, 0.5)[:20],
    ],
)
def test_what_does_not_come_in_bursts(times: Reals) -> None:
    found = bursts_of(times)
    assert found.size == 1.0
    assert found.interval == found.period == np.median(np.diff(times))
    assert found.between.all()


def test_fewer_than_two_samples_have_no_interval() -> None:
    assert bursts_of(EVEN[:1]).interval == np.inf
