# SPDX-License-Identifier: Apache-2.0
"""Clocks that are apart, told from messages that are late."""

from __future__ import annotations

import math

import numpy as np
import pytest
from checking.made import both, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.finding import Level

T1: Reals = 0.01 * np.arange(6000)
T2: Reals = 0.1 * np.arange(600)
LAG = 0.2
NOISE1: Reals = 0.01 * np.random.default_rng(1).normal(size=6000)
NOISE2: Reals = 0.01 * np.random.default_rng(2).normal(size=600)


def motion(time_s: Reals) -> Reals:
    """Three sines that have nothing in common."""
    found: Reals = np.sin(time_s) + np.sin(2.3 * time_s + 1.0) + 0.5 * np.sin(0.37 * time_s)
    return found


def checked(
    *, behind: float = 0.0, late: float = 0.0, s1_late: float = 0.0, still: bool = False
) -> Check:
    """Check two sensors, S2 0.2 s behind the motion."""
    scale = 0.0 if still else 1.0
    s1 = sensor("s1", T1, scale * motion(T1) + NOISE1, arrivals_s=T1 + s1_late)
    s2 = sensor(
        "s2",
        T2 - behind,
        scale * motion(T2 - LAG) + NOISE2,
        arrivals_s=T2 + late,
    )
    return both(s1, s2)


@pytest.mark.parametrize(
    ("behind", "text"),
    [
        (5.0, "s2's stamps are 5.0 s behind s1's although both arrive together"),
        (-5.0, "s2's stamps are 5.0 s ahead of s1's although both arrive together"),
        (-1.5, "s2's stamps are 1.5 s ahead of s1's although both arrive together"),
        (1.2, "s2's stamps are 1.2 s behind s1's although both arrive together"),
        (1.6e9, "s2's stamps are 1.60e9 s behind s1's although both arrive together"),
    ],
)
def test_clocks_that_are_apart(behind: float, text: str) -> None:
    found = checked(behind=behind)
    finding = only(found.findings, "clock offset")
    assert finding.level is Level.ERROR
    assert finding.text == text
    assert finding.remedy == "synchronize the clocks that stamp them, or stamp both on receipt"
    assert found.behind == pytest.approx(behind)
    assert found.relation is not None
    assert found.relation.lag == pytest.approx(LAG, abs=0.03)  # compared as they arrive


@pytest.mark.parametrize("behind", [-2.2, -1.5, 1.2, 1.5, 1.8, 2.5, 3.0, 4.5, 5.0])
def test_a_clock_that_is_off_by_part_of_a_sine_is_no_rate_and_no_sign(behind: float) -> None:
    found = both(
        sensor("s1", T1, np.sin(T1) + 0.3 + NOISE1),
        sensor("s2", T2 - behind, np.sin(T2), arrivals_s=T2),
    )
    assert [each.about for each in found.findings if each.level] == ["clock offset"]


@pytest.mark.parametrize(("late", "timeout"), [(0.3, "0.6 s"), (0.8, "1.1 s"), (1.6, "1.9 s")])
def test_messages_that_are_late(late: float, timeout: str) -> None:
    found = checked(late=late)
    finding = only(found.findings, "late delivery")
    assert finding.level is Level.INFO
    assert f"messages of s2 arrive {late:g} s after their timestamps" in finding.text
    assert f"s2.timeout, if it is set, must be longer than {timeout}" in finding.text
    assert found.is_fine
    assert found.behind == pytest.approx(late)
    assert found.relation is not None
    assert found.relation.lag == pytest.approx(LAG, abs=0.03)  # compared by their stamps


def test_the_fast_sensor_may_be_the_late_one() -> None:
    finding = only(checked(s1_late=0.5).findings, "late delivery")
    assert finding.text.startswith("messages of s1 arrive 0.5 s after their timestamps")


def test_both_late_alike_is_nobodys_fault() -> None:
    found = checked(late=3.0, s1_late=3.0)
    assert found.findings == ()
    assert found.behind == pytest.approx(0.0)


@pytest.mark.parametrize(("behind", "about"), [(1.5, "late delivery"), (3.0, "clock offset")])
def test_without_motion_the_size_decides(behind: float, about: str) -> None:
    assert only(checked(behind=behind, still=True).findings, about)


def test_a_message_cannot_arrive_before_it_is_stamped() -> None:
    assert only(checked(behind=-0.4, still=True).findings, "clock offset")


def test_one_clock_that_restarts() -> None:
    stamps = np.where(T1 >= 30.0, T1 - 30.0 - 1.7e9 + 0.01, T1)
    found = both(
        sensor("s1", stamps, motion(T1), arrivals_s=T1), sensor("s2", T2, motion(T2 - LAG))
    )
    assert only(found.findings, "clock step").text == (
        "timestamps of s1 jump back by 1.70e9 s at 30.0 s, those of s2 do not"
    )
    assert only(found.findings, "clock offset").text == (
        "s2's stamps are 1.70e9 s ahead of s1's although both arrive together, from 30.0 s on"
    )
    assert math.isnan(found.behind)
    assert not found.is_fine


def test_a_looped_recording_is_fine() -> None:
    found = both(
        sensor("s1", T1 % 30.0, motion(T1 % 30.0), arrivals_s=T1),
        sensor("s2", T2 % 30.0, motion(T2 % 30.0 - LAG), arrivals_s=T2),
    )
    finding = only(found.findings, "clock step")
    assert finding.level is Level.INFO
    assert finding.text == "timestamps of s1 and s2 jump back by 30.0 s at 30.0 s"
    assert found.is_fine
