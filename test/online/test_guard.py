# SPDX-License-Identifier: Apache-2.0
"""The guard of each sensor."""

from __future__ import annotations

import math

import pytest

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Drop, Guard

SECOND = 1_000_000_000


@pytest.mark.parametrize(
    ("stamp_ns", "value", "fault"),
    [
        (SECOND, 0.0, None),
        (SECOND, -1.7e308, None),
        (SECOND, math.nan, Drop.NOT_FINITE),
        (SECOND, math.inf, Drop.NOT_FINITE),
        (SECOND, -math.inf, Drop.NOT_FINITE),
        (0, 1.0, Drop.ZERO_STAMP),
        (-1, 1.0, Drop.NEGATIVE_STAMP),
        (-(2**31) * SECOND, 1.0, Drop.NEGATIVE_STAMP),
        (1, 1.0, None),
        (11 * SECOND, 1.0, None),
        (11 * SECOND + 1, 1.0, Drop.FUTURE_STAMP),
        (0, math.nan, Drop.NOT_FINITE),
        (7, 1.0, Drop.NOT_NEWER),
    ],
)
def test_what_can_never_be_used(stamp_ns: int, value: float, fault: Drop | None) -> None:
    guard = Guard()
    guard.admit(7)
    assert guard.fault(Sample(stamp_ns, value), now_ns=SECOND, future_tolerance=10.0) is fault


def test_admitted_samples_are_counted() -> None:
    guard = Guard()
    for stamp_ns in (5, 6, 9):
        guard.admit(stamp_ns)
    assert (guard.first_ns, guard.newest_ns, guard.in_a_row, guard.admitted) == (5, 9, 3, 3)


def test_drops_are_counted_by_reason() -> None:
    guard = Guard()
    assert guard.last_drop is None
    guard.drop(Drop.ZERO_STAMP)
    guard.drop(Drop.UNPAIRED, 3)
    guard.drop(Drop.NOT_FINITE, 0)
    assert guard.dropped == {Drop.ZERO_STAMP: 1, Drop.UNPAIRED: 3}
    assert guard.last_drop is Drop.UNPAIRED


def test_every_reason_says_something_else() -> None:
    assert len({reason.value for reason in Drop}) == len(Drop) == 9


def test_a_restart_forgets_the_timeline_and_keeps_the_counts() -> None:
    guard = Guard()
    for stamp_ns in (3, 4, 5):
        guard.admit(stamp_ns)
    guard.drop(Drop.NOT_NEWER)
    guard.restart()
    assert (guard.first_ns, guard.newest_ns, guard.in_a_row) == (0, None, 0)
    assert (guard.admitted, guard.dropped) == (3, {Drop.NOT_NEWER: 1})
    guard.admit(2)
    assert (guard.first_ns, guard.admitted, guard.left_ns) == (2, 4, 5)
    guard.admit(5)
    assert guard.left_ns is None
