# SPDX-License-Identifier: Apache-2.0
"""Membership functions."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import aggregator as reference

from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.parameters.fusion import BreakPoints

BREAK_POINTS = st.lists(st.floats(0.0, 1e9), min_size=2, max_size=2, unique=True).map(
    lambda pair: BreakPoints(min(pair), max(pair))
)
NON_NEGATIVE = st.floats(0.0, allow_infinity=True, allow_nan=False)


@pytest.mark.parametrize(
    ("x", "grade"),
    [
        (0.0, 0.0),
        (0.1, 0.0),
        (math.nextafter(0.1, 1.0), 0.0),
        (0.15, 0.25),
        (0.2, 0.5),
        (0.3, 1.0),
        (0.31, 1.0),
        (1.7e308, 1.0),
        (math.inf, 1.0),
    ],
)
def test_large_rises_in_a_straight_line_between_the_break_points(x: float, grade: float) -> None:
    assert large(x, BreakPoints(0.1, 0.3)) == pytest.approx(grade, abs=1e-15)


@pytest.mark.parametrize("x", [0.0, 5e-324, 1e-300, 1.0, 1e300, math.inf])
def test_the_steepest_ramp_is_a_step(x: float) -> None:
    assert large(x, BreakPoints(0.0, 5e-324)) == (1.0 if x > 0.0 else 0.0)


@given(NON_NEGATIVE, BREAK_POINTS)
def test_large_is_a_grade(x: float, ramp: BreakPoints) -> None:
    assert 0.0 <= large(x, ramp) <= 1.0
    assert large(ramp.small, ramp) == 0.0
    assert large(ramp.large, ramp) == 1.0


@given(NON_NEGATIVE, NON_NEGATIVE, BREAK_POINTS)
def test_large_never_falls(x: float, y: float, ramp: BreakPoints) -> None:
    assert large(min(x, y), ramp) <= large(max(x, y), ramp)


@given(st.floats(0.0, 1e12), BREAK_POINTS)
def test_large_is_what_the_reference_says(x: float, ramp: BreakPoints) -> None:
    exact = reference.grades(Fraction(x), (ramp.small, ramp.large))[reference.LARGE]
    assert large(x, ramp) == pytest.approx(float(exact), rel=1e-12, abs=1e-15)
