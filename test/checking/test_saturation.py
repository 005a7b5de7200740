# SPDX-License-Identifier: Apache-2.0
"""A sensor that stops at the ends of its range, and what only looks like one."""

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
NOISE2: Reals = np.random.default_rng(2).normal(size=1200)


def motion(time_s: Reals) -> Reals:
    """Slow sines that have nothing in common, with a standard deviation of about 1."""
    found: Reals = (
        np.sin(0.8 * time_s) + 0.8 * np.sin(1.7 * time_s + 1.0) + 0.6 * np.sin(0.37 * time_s)
    )
    return found


def drive(time_s: Reals) -> Reals:
    """A speed that is 0 for a few seconds now and then."""
    found: Reals = np.maximum(0.0, motion(time_s))
    return found


def checked(s1: Reals, s2: Reals) -> Check:
    return both(sensor("s1", T1, s1), sensor("s2", T2, s2 + 0.02 * NOISE2))


@pytest.mark.parametrize("noise", [0.0, 0.15])
@pytest.mark.parametrize(
    ("low", "high", "where"),
    [(-0.8, 0.8, "-0.8 and 0.8"), (-9.0, 1.0, "1"), (-0.5, 9.0, "-0.5")],
)
def test_s1_saturates(low: float, high: float, where: str, noise: float) -> None:
    s1 = np.clip(motion(T1) + noise * NOISE, low, high)
    share = f"{100.0 * float(np.mean((s1 == low) | (s1 == high))):.2g} %"
    found = checked(s1, motion(T2 - LAG))
    (finding,) = found.findings
    assert (finding.about, finding.level) == ("saturated", Level.WARNING)
    assert finding.text == (
        f"s1 saturates at {where}: {share} of its samples are there while s2 moves on; "
        "they are left out of the comparison"
    )
    assert "--start" in finding.remedy
    assert warnings(found) == [finding]
    assert found.relation is not None
    assert found.relation.middle_scale == pytest.approx(1.0, rel=0.25)
    assert found.relation.lag == pytest.approx(LAG, abs=0.16)  # 0.13 with gaps there


def test_s2_saturates() -> None:
    s2 = np.minimum(motion(T2 - LAG) + 0.02 * NOISE2, 0.8)
    found = both(sensor("s1", T1, motion(T1) + 0.02 * NOISE), sensor("s2", T2, s2))
    assert [each.about for each in found.findings] == ["saturated"]
    assert found.findings[0].text.startswith("s2 saturates at 0.8: ")


def test_another_unit_is_named_all_the_same() -> None:
    found = checked(np.clip(180.0 / np.pi * motion(T1), -200.0, 70.0), motion(T2 - LAG))
    assert {each.about for each in found.findings} == {"saturated", "scale"}
    assert only(found.findings, "scale").remedy == "s1.scale: 0.01745329"


@pytest.mark.parametrize(
    ("s1", "s2"),
    [
        pytest.param(np.round(2.0 * motion(T1)) / 2.0, motion(T2 - LAG), id="coarse steps"),
        pytest.param(np.round(20.0 * motion(T1)) / 20.0, motion(T2 - LAG), id="fine steps"),
        pytest.param(drive(T1), drive(T2 - LAG), id="at rest at zero"),
        pytest.param(
            drive(T1) + np.where(drive(T1) > 0.0, 0.05 * np.abs(NOISE), 0.0),
            drive(T2 - LAG),
            id="noise in motion only",
        ),
        pytest.param(
            np.sign(motion(T1)), np.interp(T2 - LAG, T1, np.sign(motion(T1))), id="a switch"
        ),
        pytest.param(
            np.minimum(motion(T1), 1.0), np.minimum(motion(T2 - LAG), 1.0), id="both stop there"
        ),
        pytest.param(np.full(6000, 0.5), motion(T2), id="constant"),
        pytest.param(motion(T1), motion(T2 - LAG), id="neither"),
        pytest.param(
            np.minimum(20.0 - 5.0 * np.exp(-T1 / 20.0) + 0.02 * NOISE, 19.9),
            20.0 - 5.0 * np.exp(-T2 / 20.0),
            id="a temperature at its maximum",
        ),
    ],
)
def test_what_does_not_saturate(s1: Reals, s2: Reals) -> None:
    assert "saturated" not in {each.about for each in checked(s1, s2).findings}


@pytest.mark.parametrize(
    ("low", "high", "where"), [(-0.7, 0.7, "-0.7 and 0.7"), (-9.0, 0.6, "0.6"), (-0.6, 9.0, "-0.6")]
)
@pytest.mark.parametrize("span_s", [40.0, 60.0])
def test_a_few_long_stays_at_an_end_are_no_stuck_sensor(
    low: float, high: float, where: str, span_s: float
) -> None:
    """Each is some seconds long, and of one end there are but one to three."""
    one, other = T1[span_s > T1], T2[span_s > T2]
    s1 = motion(0.6 * one) + 0.05 * NOISE[: one.size]
    s2 = np.clip(motion(0.6 * (other - LAG)), low, high)
    found = both(sensor("s1", one, s1), sensor("s2", other, s2))
    (finding,) = found.findings
    assert finding.text.startswith(f"s2 saturates at {where}: ")


def test_a_sensor_that_is_stuck_at_its_largest_value_does_not_saturate() -> None:
    s2 = motion(T2 - LAG)
    top = int(np.argmax(s2))
    s2[top : top + 60] = s2[top]
    found = both(sensor("s1", T1, motion(T1) + 0.1 * NOISE), sensor("s2", T2, s2))
    assert [each.about for each in found.findings] == ["stuck"]


def test_noise_at_rest_is_no_motion() -> None:
    times = 0.002 * np.arange(60000)
    s1 = drive(times) + 0.5 * np.random.default_rng(1).normal(size=times.size)
    found = both(sensor("s1", times, s1), sensor("s2", T2, drive(T2 - LAG)))
    assert "saturated" not in {each.about for each in found.findings}
