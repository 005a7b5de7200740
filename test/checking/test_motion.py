# SPDX-License-Identifier: Apache-2.0
"""Sensors whose samples come in bursts, stamped on receipt or not."""

from __future__ import annotations

import numpy as np
import pytest
from checking.made import both, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Level
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


@pytest.mark.parametrize("apart", [0.005, 0.02, 0.04])
@pytest.mark.parametrize("size", [2, 3, 5])
def test_a_sensor_that_measures_several_times_in_a_row_is_fine(size: int, apart: float) -> None:
    rng = np.random.default_rng(1)
    times = np.add.outer(0.5 * np.arange(240), apart * np.arange(size)).ravel()
    values = motion(times - LAG) + 0.02 * rng.normal(size=times.size)
    found = both(sensor("s1", T1, motion(T1) + 0.1 * NOISE), sensor("s2", times, values))
    assert found.findings == ()
    assert found.characters["s2"].interval == pytest.approx(0.5 / size, rel=0.01)
    assert found.relation is not None
    assert found.relation.lag == pytest.approx(LAG, abs=0.05)
    negated = both(sensor("s1", T1, 0.1 * NOISE - motion(T1)), sensor("s2", times, values))
    assert [each.about for each in negated.findings] == ["sign"]


def test_pairs_that_are_stamped_on_receipt_are_named() -> None:
    finding = only(checked(received(2)).findings, "bursts")
    assert finding.text == (
        "s2 comes in bursts of about 2, 0.2 s apart: it seems to be stamped on receipt"
    )


@pytest.mark.parametrize("apart", [0.001, 0.02])
def test_two_publishers_are_no_bursts(apart: float) -> None:
    times = np.sort(np.append(T2, T2 + apart))
    values = motion(times - LAG) + 0.5 * (np.arange(times.size) % 2)
    found = both(sensor("s1", T1, motion(T1) + 0.1 * NOISE), sensor("s2", times, values))
    assert [each.about for each in found.findings] == ["publishers"]
    assert found.relation is not None
