# SPDX-License-Identifier: Apache-2.0
"""Stamps of one sensor: unusable, odd, of two clocks, of a clock that steps."""

from __future__ import annotations

import numpy as np
import pytest
from checking.made import START_NS, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.finding import Level
from fuzzy_fusion_ros.checking.samples import SensorSamples
from fuzzy_fusion_ros.checking.stamps import judge_stamps

TIMES: Reals = 0.1 * np.arange(100)
EPOCH = START_NS * 1e-9


def stamped(stamps_s: Reals, arrivals_s: Reals = TIMES) -> SensorSamples:
    return sensor("s1", stamps_s, np.sin(stamps_s), arrivals_s=arrivals_s)


def changed(at: int, to: float) -> Reals:
    """Return regular times but for one."""
    times = TIMES.copy()
    times[at] = to
    return times


def test_regular_stamps_are_fine_however_they_arrive() -> None:
    bursts = np.ceil(TIMES / 3.0) * 3.0  # nothing for three seconds, then all at once
    for arrivals in (TIMES, TIMES + 5.0, bursts):
        found = judge_stamps(stamped(TIMES, arrivals), START_NS)
        assert found.usable.all()
        assert (found.steps, found.findings) == ((), ())


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_too_few_samples_have_no_odd_stamps(samples: int) -> None:
    found = judge_stamps(stamped(TIMES[:samples], TIMES[:samples] + 5.0), START_NS)
    assert found.usable.all()
    assert (found.steps, found.findings) == ((), ())


def test_a_gap_is_no_step_of_the_clock() -> None:
    times = np.where(TIMES > 5.0, TIMES + 20.0, TIMES)
    found = judge_stamps(stamped(times, times), START_NS)
    assert (found.steps, found.findings) == ((), ())


@pytest.mark.parametrize(
    ("stamp_s", "text"),
    [
        (-EPOCH, "1 of 100 samples of s1 are dropped: stamp is zero"),
        (-EPOCH - 5.0, "1 of 100 samples of s1 are dropped: stamp is negative: before 1970"),
        (-3600.0, "1 of 100 samples of s1 are dropped: their stamps are off by up to 3604.0 s"),
        (4.05, None),
        (4.2 - 0.15, None),
    ],
)
def test_one_odd_stamp(stamp_s: float, text: str | None) -> None:
    found = judge_stamps(stamped(changed(40, stamp_s)), START_NS)
    assert found.steps == ()
    assert np.count_nonzero(~found.usable) == (text is not None)
    if text is None:
        assert found.findings == ()
    else:
        (finding,) = found.findings
        assert finding.text.startswith(text)
        assert finding.level is Level.WARNING


def test_nanoseconds_of_a_second_or_more() -> None:
    samples = stamped(TIMES)._replace(overflows=np.arange(100) % 2 == 0)
    found = judge_stamps(samples, START_NS)
    assert np.count_nonzero(found.usable) == 50
    assert only(found.findings, "stamps").text == (
        "50 of 100 samples of s1 are dropped: nanoseconds of the stamp are 1e9 or more"
    )


def test_stamps_that_can_never_be_used_are_an_error() -> None:
    found = judge_stamps(stamped(np.full(100, -EPOCH)), START_NS)
    assert not found.usable.any()
    assert only(found.findings, "stamps").level is Level.ERROR


@pytest.mark.parametrize(("by", "at"), [(-4.0, 4.0), (7.0, 4.0), (-EPOCH, 4.0)])
def test_a_clock_that_steps(by: float, at: float) -> None:
    found = judge_stamps(stamped(np.where(at - 1e-9 <= TIMES, TIMES + by, TIMES)), START_NS)
    (step,) = found.steps
    assert found.usable.all()
    assert (step.at_ns - START_NS) * 1e-9 == pytest.approx(at)
    assert step.by == pytest.approx(by)


def test_two_publishers_whose_clocks_are_apart() -> None:
    stamps = np.where(np.arange(100) % 3 == 0, TIMES - 3600.0, TIMES)
    found = judge_stamps(stamped(stamps), START_NS)
    finding = only(found.findings, "two clocks")
    assert finding.level is Level.ERROR
    assert finding.text == "stamps of s1 alternate between two clocks 3600.0 s apart"
    assert finding.evidence["share of the second"] == pytest.approx(0.34)
    assert np.count_nonzero(found.usable) == 66


@pytest.mark.parametrize(("repeated", "level"), [(1, Level.INFO), (20, Level.WARNING)])
def test_stamps_that_are_not_newer(repeated: int, level: Level) -> None:
    times = 0.01 * np.arange(1000)
    times[np.linspace(10, 900, repeated).astype(int)] -= 0.01
    found = judge_stamps(stamped(times, 0.01 * np.arange(1000)), START_NS)
    finding = only(found.findings, "stamps")
    assert finding.text == (
        f"{repeated} of 1000 samples of s1 are dropped: stamp is not newer than the last"
    )
    assert finding.level is level


def test_messages_without_a_stamp() -> None:
    samples = sensor("s2", TIMES, TIMES, is_stamped=False)
    (finding,) = judge_stamps(samples, START_NS).findings
    assert finding.level is Level.INFO
    assert "no timestamp; using the time of arrival" in finding.text


def test_a_clock_is_not_followed_through_impossible_nanoseconds() -> None:
    stamps = np.where(TIMES < 4.0, TIMES, TIMES + 3.0)
    samples = stamped(stamps)
    wrong = (TIMES > 3.0) & (TIMES < 5.0)
    found = judge_stamps(samples._replace(overflows=wrong), START_NS)
    assert found.steps == ()
    assert [each.about for each in found.findings] == ["stamps"]
    assert np.count_nonzero(found.usable) == np.count_nonzero(~wrong)
