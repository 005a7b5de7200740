"""The guard in front of each sensor."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.online.guard import OLDER_IN_A_ROW, Drop, Guard

SECOND = 1_000_000_000
STEP = 10_000_000


def guard_after(*stamps_ns: int) -> Guard:
    """Return a guard that has admitted samples of these stamps."""
    guard = Guard()
    for stamp_ns in stamps_ns:
        assert guard.admit(stamp_ns)
    return guard


def regular(samples: int, start_ns: int = SECOND) -> list[int]:
    """Return evenly spaced stamps."""
    return [start_ns + k * STEP for k in range(samples)]


@pytest.mark.parametrize(
    ("stamp_ns", "value", "fault"),
    [
        (SECOND, 0.0, None),
        (SECOND, -1.7e308, None),
        (SECOND, math.nan, Drop.NOT_FINITE),
        (SECOND, math.inf, Drop.NOT_FINITE),
        (SECOND, -math.inf, Drop.NOT_FINITE),
        (0, 1.0, Drop.ZERO_STAMP),
        (1, 1.0, None),
        (11 * SECOND, 1.0, None),
        (11 * SECOND + 1, 1.0, Drop.FUTURE_STAMP),
        (0, math.nan, Drop.NOT_FINITE),
    ],
)
def test_what_can_never_be_used(stamp_ns: int, value: float, fault: Drop | None) -> None:
    assert Guard().fault(stamp_ns, value, now_ns=SECOND, future_tolerance=10.0) is fault


def test_stamps_must_rise() -> None:
    guard = guard_after(5, 6)
    assert [guard.admit(stamp_ns) for stamp_ns in (6, 5, 7)] == [False, False, True]
    assert (guard.first_ns, guard.newest_ns, guard.admitted) == (5, 7, 3)


def test_drops_are_counted_by_reason() -> None:
    guard = Guard()
    assert guard.last_drop is None
    guard.drop(Drop.ZERO_STAMP)
    guard.drop(Drop.UNPAIRED, 3)
    guard.drop(Drop.NOT_FINITE, 0)
    assert guard.dropped == {Drop.ZERO_STAMP: 1, Drop.UNPAIRED: 3}
    assert guard.last_drop is Drop.UNPAIRED


def test_every_reason_says_something_else() -> None:
    assert len({reason.value for reason in Drop}) == len(Drop) == 6


@pytest.mark.parametrize(
    ("back_ns", "jumped"), [(-STEP, False), (0, False), (SECOND, False), (SECOND + 1, True)]
)
def test_a_stamp_older_by_more_than_the_tolerance_is_a_jump(back_ns: int, jumped: bool) -> None:
    guard = guard_after(1, 10 * SECOND)
    assert guard.jumped_back(10 * SECOND - back_ns, tolerance=1.0) is jumped


def test_the_first_sample_is_no_jump() -> None:
    assert not Guard().jumped_back(1, tolerance=0.001)


def test_older_ones_in_a_row_are_a_jump_when_they_rise() -> None:
    guard = guard_after(*regular(100))
    late = regular(OLDER_IN_A_ROW, SECOND + STEP)
    jumps = [guard.jumped_back(stamp_ns, 10.0) for stamp_ns in late]
    assert jumps == [False] * (OLDER_IN_A_ROW - 1) + [True]


def test_older_ones_that_fall_are_only_late() -> None:
    guard = guard_after(*regular(100))
    late = reversed(regular(3 * OLDER_IN_A_ROW, SECOND + STEP))
    assert not any(guard.jumped_back(stamp_ns, 10.0) for stamp_ns in late)


def test_a_newer_one_between_older_ones_ends_their_row() -> None:
    guard = guard_after(*regular(100))
    newest = regular(120)[100:]
    for late, new in zip(regular(20, SECOND + STEP), newest, strict=True):
        assert not guard.jumped_back(late, 10.0)
        assert not guard.jumped_back(new, 10.0)
        assert guard.admit(new)


@pytest.mark.parametrize("back", [0, 1, SECOND - 1])
def test_a_looped_recording_jumps_at_its_first_sample(back: int) -> None:
    """However short it is: no newer than the first of many cannot be late."""
    guard = guard_after(*regular(OLDER_IN_A_ROW))
    assert guard.jumped_back(SECOND - back, tolerance=10.0)


def test_a_late_one_before_the_first_of_few_is_only_late() -> None:
    guard = guard_after(*regular(OLDER_IN_A_ROW - 1))
    assert not guard.jumped_back(SECOND - 1, tolerance=10.0)


def test_a_restart_forgets_the_timeline_and_keeps_the_counts() -> None:
    guard = guard_after(*regular(3))
    guard.drop(Drop.NOT_NEWER)
    guard.restart()
    assert (guard.first_ns, guard.newest_ns) == (0, None)
    assert (guard.admitted, guard.dropped) == (3, {Drop.NOT_NEWER: 1})
    assert not guard.jumped_back(5, 0.001)
    assert guard.admit(5)
    assert (guard.first_ns, guard.admitted) == (5, 4)


@given(st.lists(st.integers(1, 50), max_size=50))
def test_what_is_admitted_rises(stamps_ns: list[int]) -> None:
    guard = Guard()
    admitted = [stamp_ns for stamp_ns in stamps_ns if guard.admit(stamp_ns)]
    assert admitted == sorted(set(admitted))
    assert guard.admitted == len(admitted)
    assert guard.newest_ns == (admitted[-1] if admitted else None)
