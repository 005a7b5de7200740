# SPDX-License-Identifier: Apache-2.0
"""The timeline: late samples, single odd stamps, loops, resets, two publishers at once."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.timeline import (
    EVIDENCE,
    HELD,
    LATE_EVIDENCE,
    MOST_EVIDENCE,
    Admission,
    Timeline,
)

SECOND = 1_000_000_000
STEP = 10_000_000
HOUR = 3600 * SECOND
START = 10 * HOUR


class Fed:
    """A timeline of two sensors, and the stamps that it has admitted."""

    def __init__(self) -> None:
        self.s1, self.s2 = Guard(), Guard()
        self.timeline = Timeline(self.s1, self.s2)
        self.admitted: list[int] = []
        self.restarts = 0

    def __call__(self, stamp_ns: int, guard: Guard | None = None) -> Admission:
        """Feed a sample, of S1 unless said otherwise."""
        admission = self.timeline.receive(
            guard or self.s1, Sample(stamp_ns, 0.0), 10**18, future_tolerance=10.0
        )
        self.admitted += [sample.stamp_ns for _, sample in admission.admitted]
        self.restarts += admission.restarted
        return admission


@pytest.fixture
def fed() -> Fed:
    """Return a timeline that both sensors have been on for a second."""
    made = Fed()
    for stamp_ns in regular(100):
        made(stamp_ns, made.s2)
        made(stamp_ns)
    made.admitted.clear()
    return made


def regular(samples: int, start_ns: int = START) -> list[int]:
    """Return evenly spaced stamps."""
    return [start_ns + k * STEP for k in range(samples)]


NEXT = START + 100 * STEP


@pytest.mark.parametrize("back_ns", [1, SECOND // 2, 2 * SECOND, HOUR])
def test_one_old_stamp_is_dropped_and_counted(fed: Fed, back_ns: int) -> None:
    assert fed(NEXT - STEP - back_ns) == HELD
    assert fed(NEXT).admitted == ((fed.s1, Sample(NEXT, 0.0)),)
    assert fed.s1.dropped == {Drop.NOT_NEWER: 1}
    assert fed.restarts == 0


def test_one_old_stamp_of_each_at_different_times_is_no_evidence(fed: Fed) -> None:
    for guard in (fed.s1, fed.s2):
        fed(START - HOUR, guard)
        fed(NEXT, guard)
    assert (fed.restarts, fed.s1.dropped, fed.s2.dropped) == (
        0,
        {Drop.NOT_NEWER: 1},
        {Drop.NOT_NEWER: 1},
    )


def test_what_is_held_at_the_end_is_counted_too(fed: Fed) -> None:
    fed(START)
    fed.timeline.finish()
    assert fed.s1.dropped == {Drop.NOT_NEWER: 1}


def test_a_duplicate_is_dropped_at_once(fed: Fed) -> None:
    assert fed(NEXT - STEP) == Admission(drop=Drop.NOT_NEWER)


def test_old_stamps_in_a_row_are_a_new_timeline_and_none_is_lost(fed: Fed) -> None:
    old = regular(EVIDENCE + 2, START - HOUR)
    admissions = [fed(stamp_ns) for stamp_ns in old]
    assert [each.restarted for each in admissions] == [False, False, True, False, False]
    assert fed.admitted == old
    assert not fed.s1.dropped


def test_one_old_stamp_of_each_sensor_is_a_new_timeline(fed: Fed) -> None:
    assert fed(START - HOUR, fed.s2) == HELD
    admission = fed(START - HOUR + STEP)
    assert admission.restarted
    assert [guard for guard, _ in admission.admitted] == [fed.s2, fed.s1]


def test_late_samples_in_a_row_are_a_new_timeline_only_when_they_rise(fed: Fed) -> None:
    late = regular(LATE_EVIDENCE, START + STEP)
    assert [fed(stamp_ns).restarted for stamp_ns in late] == [False] * (LATE_EVIDENCE - 1) + [True]
    assert fed.admitted == late


def test_late_samples_that_fall_are_only_late(fed: Fed) -> None:
    for stamp_ns in reversed(regular(50, START + STEP)):
        assert not fed(stamp_ns).restarted
    fed.timeline.finish()
    assert fed.s1.dropped == {Drop.NOT_NEWER: 50}


def test_a_newer_one_between_late_ones_ends_their_row(fed: Fed) -> None:
    for late, new in zip(regular(20, START + STEP), regular(20, NEXT), strict=True):
        assert fed(late) == HELD
        assert len(fed(new).admitted) == 1
    assert (fed.restarts, fed.s1.dropped) == (0, {Drop.NOT_NEWER: 20})


@pytest.mark.parametrize("back_ns", [0, 1, SECOND - 1])
def test_a_short_recording_that_loops_is_seen_as_soon_as_a_long_one(back_ns: int) -> None:
    fed = Fed()
    for stamp_ns in regular(LATE_EVIDENCE):
        fed(stamp_ns)
    old = regular(EVIDENCE, START - back_ns)
    assert [fed(stamp_ns).restarted for stamp_ns in old] == [False, False, True]


@pytest.mark.parametrize(("true", "old"), [(1, 1), (2, 1), (1, 2), (1, 5), (3, 7), (1, 40)])
def test_two_publishers_with_clocks_apart_do_not_restart_for_ever(true: int, old: int) -> None:
    """However their samples interleave: once one timeline holds, it goes on holding."""
    fed = Fed()
    now = [START, START - HOUR]
    for _ in range(2000):
        for which, samples in ((0, true), (1, old)):
            for _ in range(samples):
                now[which] += STEP
                fed(now[which])
    assert fed.restarts <= 1 + math.log2(MOST_EVIDENCE / EVIDENCE)
    last = fed.admitted[-1000:]
    assert last == sorted(last)
    total = fed.s1.admitted + sum(fed.s1.dropped.values())
    assert 2000 * (true + old) - total < 64  # those are held


def test_a_false_start_is_left_again_and_nothing_of_the_true_time_is_lost(fed: Fed) -> None:
    old, true = regular(EVIDENCE, START - HOUR), regular(10, NEXT)
    for stamp_ns in (*old, *true):
        fed(stamp_ns)
    assert fed.admitted == [*old, *true]
    assert fed.restarts == 2


def test_time_that_passes_where_it_jumped_back_from_goes_on(fed: Fed) -> None:
    start = NEXT - 3 * SECOND
    for stamp_ns in regular(1000, start):
        fed(stamp_ns)
    assert fed.restarts == 1
    assert fed.admitted == regular(1000, start)


def test_the_clock_may_say_first_that_time_jumped(fed: Fed) -> None:
    fed(START - HOUR, fed.s2)
    admission = fed.timeline.restart()
    assert admission.restarted
    assert admission.admitted == ((fed.s2, Sample(START - HOUR, 0.0)),)
    assert len(fed(START - HOUR).admitted) == 1


def test_a_reset_forgets_everything_but_the_counts(fed: Fed) -> None:
    fed(START)
    fed.timeline.reset()
    assert (fed.s1.dropped, fed.s1.newest_ns, fed.s1.left_ns) == ({Drop.NOT_NEWER: 1}, None, None)
    assert len(fed(5).admitted) == 1


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 50)), max_size=80))
def test_what_is_admitted_rises_but_for_restarts_and_all_is_accounted_for(
    stream: list[tuple[bool, int]],
) -> None:
    fed = Fed()
    newest: dict[int, int] = {}
    for first, tenths in stream:
        admission = fed(tenths * SECOND // 10, fed.s1 if first else fed.s2)
        if admission.restarted:
            newest.clear()
        for guard, sample in admission.admitted:
            assert sample.stamp_ns > newest.get(id(guard), 0)
            newest[id(guard)] = sample.stamp_ns
    fed.timeline.finish()
    for guard, ours in ((fed.s1, True), (fed.s2, False)):
        sent = sum(first is ours for first, _ in stream)
        assert guard.admitted + sum(guard.dropped.values()) == sent
