# SPDX-License-Identifier: Apache-2.0
"""S2 held, and its rate."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from reference import aggregator as reference

from fuzzy_fusion_ros.core.aggregator import SlowSensor, no_slow_sensor, observe_slow

SECOND = 1_000_000_000


def rates(
    stamps_ns: list[int], values: list[float], time_constant: float, longest_gap: float = math.inf
) -> list[float]:
    """Feed samples and return the rate after each."""
    s2 = no_slow_sensor()
    found = []
    for stamp_ns, value in zip(stamps_ns, values, strict=True):
        s2 = observe_slow(time_constant, longest_gap, s2, stamp_ns, value)
        found.append(s2.rate)
    return found


def test_the_first_sample_is_held_and_shows_no_rate() -> None:
    s2 = observe_slow(0.03, 5.0, no_slow_sensor(), SECOND, 7.0)
    assert s2 == SlowSensor(samples=1, stamp_ns=SECOND, value=7.0, rate=0.0)


def test_without_a_time_constant_it_is_the_difference_over_the_actual_time() -> None:
    stamps_ns = [SECOND, SECOND + 10_000_000, SECOND + 510_000_000]
    assert rates(stamps_ns, [1.0, 1.5, 0.5], 0.0) == pytest.approx([0.0, 50.0, -2.0])


def test_a_time_constant_slows_the_rate() -> None:
    after_one_time_constant = rates([SECOND, SECOND + 30_000_000], [0.0, 0.06], 0.03)
    assert after_one_time_constant[-1] == pytest.approx(1.0)  # of a slope of 2


def test_a_steady_ramp_ends_at_its_slope() -> None:
    stamps_ns = [SECOND + k * 10_000_000 for k in range(200)]
    assert rates(stamps_ns, [0.03 * k for k in range(200)], 0.03)[-1] == pytest.approx(3.0)


@pytest.mark.parametrize("time_constant", [0.0, 0.03, 2.0])
def test_irregular_stamps_give_what_the_reference_gives(time_constant: float) -> None:
    generator = np.random.default_rng(4)
    stamps_ns = (SECOND + np.cumsum(generator.integers(1_000_000, 90_000_000, 150))).tolist()
    values = np.cumsum(generator.normal(0.0, 0.1, 150)).tolist()
    exact = reference.rates(stamps_ns, values, time_constant, 0.08)
    found = rates(stamps_ns, values, time_constant, 0.08)
    assert found.count(0.0) == exact.count(0) > 1  # gaps are among them
    assert found == pytest.approx([float(rate) for rate in exact], rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("gap_ns", "rate"), [(500_000_000, 2.0), (500_000_001, 0.0)])
def test_a_gap_restarts_the_rate(gap_ns: int, rate: float) -> None:
    first = SECOND + 10_000_000
    found = rates([SECOND, first, first + gap_ns], [0.0, 1.0, 2.0], 0.0, 0.5)
    assert found[1:] == pytest.approx([100.0, rate])


def test_samples_are_counted_over_a_gap() -> None:
    s2 = observe_slow(0.0, 0.5, no_slow_sensor(), SECOND, 0.0)
    assert observe_slow(0.0, 0.5, s2, 10 * SECOND, 1.0).samples == 2


@given(
    st.floats(0.0, 1e3),
    st.lists(
        st.tuples(st.integers(1, 10 * SECOND), st.floats(allow_nan=False, allow_infinity=False)),
        min_size=2,
        max_size=8,
    ),
)
@example(0.0, [(1, 1.7e308), (1, -1.7e308), (1, 1.7e308)])
@example(1e3, [(1, -1.7e308), (1, 1.7e308), (10 * SECOND, 1.7e308)])
def test_finite_samples_give_a_finite_rate(
    time_constant: float, samples: list[tuple[int, float]]
) -> None:
    stamps_ns = np.cumsum([step for step, _ in samples]).tolist()
    found = rates(stamps_ns, [value for _, value in samples], time_constant)
    assert all(math.isfinite(rate) for rate in found)


def test_the_state_that_goes_in_is_left_as_it_was() -> None:
    before = observe_slow(0.03, 5.0, no_slow_sensor(), SECOND, 1.0)
    copy = SlowSensor(*before)
    observe_slow(0.03, 5.0, before, 2 * SECOND, 2.0)
    assert before == copy
