# SPDX-License-Identifier: Apache-2.0
"""A signal's recent past."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.delay_line import (
    CAPACITY,
    REACH,
    DelayLine,
    delayed,
    empty_line,
    extended,
)

SECOND = 1_000_000_000
MILLISECOND = 1_000_000


def line_of(stamps_ns: list[int], values: list[float], delay: float) -> DelayLine:
    """Return a line that has seen a signal."""
    line = empty_line()
    for stamp_ns, value in zip(stamps_ns, values, strict=True):
        line = extended(line, stamp_ns, value, delay)
    return line


def kept(line: DelayLine) -> list[tuple[int, float]]:
    """Return a line's points."""
    points = zip(line.stamps_ns.tolist(), line.values.tolist(), strict=True)
    return list(points)[CAPACITY - line.filled :]


def test_an_empty_line_gives_the_newest_sample_whatever_the_delay() -> None:
    for delay in (0.0, 0.1, 100.0):
        assert delayed(empty_line(), SECOND, 7.0, SECOND, delay) == 7.0


def test_points_are_kept_in_order_and_the_oldest_go_first() -> None:
    stamps_ns = [k * SECOND for k in range(1, 51)]
    line = line_of(stamps_ns, [float(k) for k in range(50)], 0.0)
    assert kept(line) == [(k * SECOND, k - 1.0) for k in range(51 - CAPACITY, 51)]


def test_points_too_close_for_the_delay_are_left_out() -> None:
    stamps_ns = [SECOND + k * MILLISECOND for k in range(100)]
    line = line_of(stamps_ns, [0.0] * 100, delay=REACH * 0.010)
    assert [stamp_ns for stamp_ns, _ in kept(line)] == stamps_ns[::10]


def test_a_line_that_goes_in_is_left_as_it_was() -> None:
    line = line_of([SECOND], [1.0], 0.0)
    before = kept(line)
    extended(line, 2 * SECOND, 2.0, 0.0)
    assert kept(line) == before


@pytest.mark.parametrize(
    ("stamp_ms", "delay", "value"),
    [
        (1040, 0.0, 5.0),  # the newest
        (1050, 0.0, 5.0),  # behind the newest
        (1050, 0.01, 5.0),
        (1040, 0.01, 4.0),
        (1040, 0.015, 3.5),
        (1030, 0.015, 2.5),  # as a late sample of S2 asks
        (1040, 0.04, 1.0),
        (1040, 9.0, 1.0),  # before the first
        (1000, 0.01, 1.0),
    ],
)
def test_it_is_a_straight_line_between_points(stamp_ms: int, delay: float, value: float) -> None:
    stamps_ns = [1000 * MILLISECOND + k * 10 * MILLISECOND for k in range(5)]
    line = line_of(stamps_ns[:-1], [1.0, 2.0, 3.0, 4.0], 0.0)
    found = delayed(line, stamps_ns[-1], 5.0, stamp_ms * MILLISECOND, delay)
    assert found == pytest.approx(value)


@pytest.mark.parametrize("step_ms", [1, 3, 10, 200])
@pytest.mark.parametrize("delay", [0.0, 0.05, 0.3])
def test_a_ramp_is_exact_at_any_sample_rate(step_ms: int, delay: float) -> None:
    """So the line reaches back over its delay, however dense the samples."""
    stamps_ns = [SECOND + k * step_ms * MILLISECOND for k in range(2000)]
    values = [stamp_ns * 1e-9 for stamp_ns in stamps_ns]
    line = line_of(stamps_ns[:-1], values[:-1], delay)
    now_ns = stamps_ns[-1]
    assert delayed(line, now_ns, values[-1], now_ns, delay) == pytest.approx(now_ns * 1e-9 - delay)


@given(st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=CAPACITY), st.floats(0.0, 1.0))
def test_it_is_what_interpolation_says(values: list[float], delay: float) -> None:
    stamps_ns = [SECOND + k * 50 * MILLISECOND for k in range(len(values))]
    line = line_of(stamps_ns[:-1], values[:-1], delay)
    found = delayed(line, stamps_ns[-1], values[-1], stamps_ns[-1], delay)
    asked = stamps_ns[-1] * 1e-9 - delay
    expected = np.interp(asked, np.array(stamps_ns) * 1e-9, values)
    assert found == pytest.approx(float(expected), abs=1e-6)


def test_two_points_of_one_stamp_are_no_slope() -> None:
    line = line_of([SECOND], [1.0], 0.0)
    assert delayed(line, SECOND, 3.0, SECOND, 1e-12) == 1.0
