# SPDX-License-Identifier: Apache-2.0
"""Time, bounds, lags, variances and errors."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.covariance import Covariance, corrected, gain
from fuzzy_fusion_ros.core.numerics import LARGEST, bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.parameters.errors import BagError, FusionError, MessageError, ParameterError


@pytest.mark.parametrize(
    ("earlier_ns", "later_ns", "seconds"),
    [
        (0, 1, 1e-9),
        (1_700_000_000_000_000_000, 1_700_000_000_000_000_001, 1e-9),
        (2_000_000_000, 500_000_000, -1.5),
        (7, 7, 0.0),
    ],
)
def test_a_difference_of_stamps_is_exact(earlier_ns: int, later_ns: int, seconds: float) -> None:
    assert seconds_between(earlier_ns, later_ns) == seconds


@pytest.mark.parametrize(
    ("x", "expected"),
    [
        (0.0, 0.0),
        (-1.5, -1.5),
        (LARGEST, LARGEST),
        (1.7e308, LARGEST),
        (math.inf, LARGEST),
        (-math.inf, -LARGEST),
    ],
)
def test_bounded(x: float, expected: float) -> None:
    assert bounded(x) == expected


def test_squares_and_quotients_within_the_bound_are_finite() -> None:
    assert math.isfinite((2.0 * LARGEST) ** 2)
    assert math.isfinite((2.0 * LARGEST) / 1e-9)


@pytest.mark.parametrize(
    ("dt", "time_constant", "gain"),
    [
        (0.01, 0.0, 1.0),
        (0.2, 0.2, 1.0 - math.exp(-1.0)),
        (0.0, 0.2, 0.0),
        (1e9, 1e-3, 1.0),
    ],
)
def test_the_gain_of_a_lag(dt: float, time_constant: float, gain: float) -> None:
    assert lag_gain(dt, time_constant) == pytest.approx(gain)


@given(st.floats(0.0, 10.0), st.floats(0.0, 10.0), st.floats(1e-3, 10.0))
def test_two_steps_of_a_lag_go_as_far_as_one(a: float, b: float, time_constant: float) -> None:
    left = (1.0 - lag_gain(a, time_constant)) * (1.0 - lag_gain(b, time_constant))
    assert 1.0 - lag_gain(a + b, time_constant) == pytest.approx(left, abs=1e-15)


@pytest.mark.parametrize("kind", [ParameterError, MessageError, BagError])
def test_every_error_is_of_the_family(kind: type[Exception]) -> None:
    assert issubclass(kind, FusionError)


def test_owners_add_their_names_to_an_error() -> None:
    inner = ParameterError("small", "got 2, expected less than large 1")
    outer = inner.under("difference").under("aggregator")
    assert outer.name == "aggregator.difference.small"
    assert outer.problem == inner.problem
    assert str(outer) == (
        "parameter aggregator.difference.small: got 2, expected less than large 1"
    )


def test_what_rounding_leaves_below_0_of_a_variance_is_0() -> None:
    """Off the diagonal is as much as the variances allow, and the last digit more."""
    more = math.nextafter(1.0, 2.0)
    p = Covariance(1.0, 1.0, 1.0, more, 1.0, 1.0, more, 1.0, more, 1.0)
    after = corrected(p, gain(p, 1e-300), 1e-300)
    assert (after.cc, after.bb, after.m11) == (0.0, 0.0, 0.0)
