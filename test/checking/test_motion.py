# SPDX-License-Identifier: Apache-2.0
"""How samples come: one by one, or in bursts that are stamped on receipt."""

from __future__ import annotations

import numpy as np
import pytest
from checking.made import both, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Level
from fuzzy_fusion_ros.checking.motion import bursts_of
from fuzzy_fusion_ros.checking.recent import warnings

T1: Reals = 0.02 * np.arange(6000)
T2: Reals = 0.1 * np.arange(1200)
LAG = 0.4
NOISE: Reals = np.random.default_rng(1).normal(size=6000)


def motion(time_s: Reals) -> Reals:
    found: Reals = np.sin(0.8 * time_s) + np.sin(1.7 * time_s + 1.0) + 0.6 * np.sin(0.37 * time_s)
    return found


def received(size: int, apart: float = 1e-3) -> Reals:
    """When the samples of T2 arrive if a driver delivers as many at once."""
    k = np.arange(T2.size)
    found: Reals = T2[np.minimum(k - k % size + size - 1, T2.size - 1)] + apart * (k % size)
    return found


def checked(stamps_s: Reals, arrivals_s: Reals | None = None) -> Check:
    return both(
        sensor("s1", T1, motion(T1) + 0.1 * NOISE),
        sensor("s2", stamps_s, motion(T2 - LAG), arrivals_s=arrivals_s),
    )


@pytest.mark.parametrize(("size", "apart"), [(3, 1e-3), (5, 1e-3), (5, 1e-6), (15, 2e-3)])
def test_bursts_are_named_and_compared_all_the_same(size: int, apart: float) -> None:
    found = checked(received(size, apart))
    (finding,) = found.findings
    assert (finding.about, finding.level) == ("bursts", Level.WARNING)
    assert finding.text == (
        f"s2 comes in bursts of about {size}, {0.1 * size:.1f} s apart: it seems to be stamped on "
        "receipt"
    )
    assert finding.remedy == "stamp it when it is measured"
    assert warnings(found) == [finding]
    assert found.characters["s2"].interval == pytest.approx(0.1, rel=0.05)
    assert found.relation is not None
    waiting = 0.05 * (size - 1)
    assert found.relation.lag == pytest.approx(LAG + waiting, abs=0.1)


def test_samples_that_wait_for_random_times() -> None:
    wait = np.random.default_rng(2).uniform(0.2, 1.2, T2.size)
    stamps = np.maximum.accumulate(T2 + wait) + 1e-6 * np.arange(T2.size)
    found = checked(stamps)
    assert only(found.findings, "bursts").level is Level.WARNING
    assert found.relation is not None


def test_bursts_whose_stamps_are_right_are_fine() -> None:
    arrivals = received(30)  # nothing for three seconds
    assert "bursts" not in {each.about for each in checked(T2, arrivals).findings}


RNG = np.random.default_rng(3)


@pytest.mark.parametrize(
    "times",
    [
        T2,
        T2 + 0.04 * RNG.uniform(-1.0, 1.0, T2.size),
        np.cumsum(RNG.exponential(0.1, 1200)),
        np.append(0.002 * np.arange(1000), 2.0 + np.arange(100)),  # a rate that changes
        np.sort(np.append(T2, T2 + 0.005)),  # two publishers
        np.append(T1[:3000], T1[3000:] + 3600.0),
        (0.02 * np.arange(1000) + 2.0 * (np.arange(1000) // 10)),  # seen now and then
    ],
)
def test_what_does_not_come_in_bursts(times: Reals) -> None:
    found = bursts_of(times)
    assert found.size == 1.0
    assert found.interval == found.period == np.median(np.diff(times))


def test_fewer_than_two_samples_have_no_interval() -> None:
    assert bursts_of(T2[:1]).interval == np.inf
