# SPDX-License-Identifier: Apache-2.0
"""S1 on its own: spikes and low-pass."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.conditioning import (
    LONGEST_SPIKE,
    FastSensor,
    carried_on,
    condition,
    no_fast_sensor,
)
from fuzzy_fusion_ros.core.numerics import LARGEST
from fuzzy_fusion_ros.parameters.fusion import FastSensorParameters

SECOND = 1_000_000_000
STEP = 10_000_000


def conditioned(
    parameters: FastSensorParameters,
    s1: list[float],
    rate: float = 0.0,
    s2_decides: bool = False,
    step_ns: int = STEP,
) -> list[FastSensor]:
    """Feed samples of S1 and return what is kept after each."""
    kept = no_fast_sensor()
    said = []
    for k, value in enumerate(s1):
        kept = condition(parameters, kept, rate, s2_decides, SECOND + k * step_ns, value)
        said.append(kept)
    return said


def values(said: list[FastSensor]) -> list[float]:
    """Return the conditioned values."""
    return [each.smooth.value for each in said]


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=20))
def test_by_default_s1_passes_bit_for_bit(s1: list[float]) -> None:
    said = conditioned(FastSensorParameters(), s1)
    assert np.array(values(said)).tobytes() == np.array(s1).tobytes()


def test_samples_are_counted_with_their_stamps() -> None:
    """None are while all steps are off, so that conditioning starts anew when one is on."""
    for parameters, counts in (
        (FastSensorParameters(), (0, 0)),
        (FastSensorParameters(lowpass_time_constant=0.1), (1, 2)),
    ):
        said = conditioned(parameters, [0.1, 0.2])
        assert [(each.samples, each.stamp_ns) for each in said] == [
            (counts[0], SECOND),
            (counts[1], SECOND + STEP),
        ]


@pytest.mark.parametrize(
    ("s1", "passed"),
    [
        ([0.0, 9.0, 0.25], [0.0, 0.0, 0.25]),
        ([0.0, -9.0, 0.25], [0.0, 0.0, 0.25]),
        ([0.0, 0.5, 0.75], [0.0, 0.5, 0.75]),  # as far as the threshold is none
        ([9.0, 0.0, 9.25], [9.0, 9.0, 9.25]),  # the first is taken whatever it is,
        ([9.0, 0.0, 0.0], [9.0, 9.0, 0.0]),  # and soon given up
        ([0.0, 0.0, 9.0, -9.0, 0.25], [0.0, 0.0, 0.0, 0.0, 0.25]),
        ([0.0, 9.0, 0.0, 9.0, 0.0, 9.0, 0.0], [0.0] * 7),
        ([0.0] * 20 + [9.0] * LONGEST_SPIKE + [0.0], [0.0] * (LONGEST_SPIKE + 21)),
        ([0.0] * 20 + [9.0] * (LONGEST_SPIKE + 2), [0.0] * (LONGEST_SPIKE + 20) + [9.0] * 2),
        ([0.0] * 5 + [9.0] * 6 + [0.0] * 2, [0.0] * 10 + [9.0, 0.0, 0.0]),  # taken for a moment
        ([0.0] * 9 + [0.5, -0.25], [0.0] * 9 + [0.5, -0.25]),  # a small one locks none out
        ([10.0 * k for k in range(5)], [0.0, 0.0, 20.0, 30.0, 40.0]),  # steeper than that: all
    ],
)
def test_a_spike_is_left_out(s1: list[float], passed: list[float]) -> None:
    assert values(conditioned(FastSensorParameters(spike_threshold=0.5), s1)) == passed


def test_through_a_spike_s1_goes_on_at_the_rate_of_s2() -> None:
    ramp = [0.01 * k for k in range(500)]
    for time_constant in (0.0, 0.1):
        parameters = FastSensorParameters(spike_threshold=0.5, lowpass_time_constant=time_constant)
        said = values(conditioned(parameters, [*ramp[:-5], *[9.0] * 5], rate=1.0))
        assert said[-1] == pytest.approx(ramp[-1], abs=1e-6)


def test_where_s2_decides_samples_are_rejected_until_the_timeout() -> None:
    parameters = FastSensorParameters(spike_threshold=0.5, timeout=1.005)
    said = conditioned(parameters, [0.0] * 20 + [9.0] * 150, s2_decides=True)
    assert values(said)[19 + 100] == 0.0
    assert said[19 + 100].smooth.rejected == pytest.approx(1.0)
    assert values(said)[19 + 101] == 9.0
    steps = [each.smooth.step for each in said]
    assert steps == [0.0] * (20 + 100) + [9.0] + [0.0] * 49


def test_the_low_pass_goes_its_way_to_a_step() -> None:
    """Within its time constant most of it; its trend, slower, overshoots by a little."""
    said = values(conditioned(FastSensorParameters(lowpass_time_constant=0.1), [0.0] + [1.0] * 300))
    assert said[10] == pytest.approx(1.0 - math.exp(-1.0), abs=0.08)
    assert max(said) < 1.15
    assert said[-1] == pytest.approx(1.0, abs=0.01)


def test_a_ramp_passes_without_lag() -> None:
    ramp = [0.01 * k for k in range(500)]
    said = values(conditioned(FastSensorParameters(lowpass_time_constant=0.1), ramp))
    assert said[-1] == pytest.approx(ramp[-1], abs=1e-4)


def test_a_low_pass_quiets_noise() -> None:
    noise = np.random.default_rng(0).normal(0.0, 1.0, 3000).tolist()
    smooth = FastSensorParameters(lowpass_time_constant=0.2)
    assert np.std(values(conditioned(smooth, noise))[500:]) < 0.4


@pytest.mark.parametrize(("gap_ns", "value"), [(SECOND, 1.0 - math.exp(-1.0)), (SECOND + 1, 1.0)])
def test_a_gap_restarts_the_low_pass(gap_ns: int, value: float) -> None:
    parameters = FastSensorParameters(lowpass_time_constant=1.0, timeout=1.0)
    said = conditioned(parameters, [0.0, 1.0], step_ns=gap_ns)
    assert values(said) == pytest.approx([0.0, value])


def test_a_level_that_is_carried_on_stays_in_range() -> None:
    kept = conditioned(FastSensorParameters(), [0.0])[-1].smooth
    steep = kept._replace(level=LARGEST, value=LARGEST, slope=LARGEST)
    on = carried_on(FastSensorParameters(), steep, LARGEST, 100.0, 0.0)
    assert (on.level, on.value) == (LARGEST, LARGEST)


EVERYTHING = FastSensorParameters(spike_threshold=1.0, lowpass_time_constant=0.05)
FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(
    st.lists(FINITE, min_size=1, max_size=25),
    st.sampled_from([1, 1000, STEP, SECOND]),
    st.booleans(),
)
@example([1.7e308, -1.7e308] * 8, 1, True)
@example([1.7e308, -1.7e308] * 8, STEP, False)
def test_what_is_finite_stays_finite(s1: list[float], step_ns: int, s2_decides: bool) -> None:
    for parameters in (EVERYTHING, FastSensorParameters(lowpass_time_constant=0.1)):
        said = conditioned(parameters, s1, 1e100, s2_decides, step_ns)
        assert all(math.isfinite(value) for value in values(said))
