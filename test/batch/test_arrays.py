# SPDX-License-Identifier: Apache-2.0
"""Statistics of arrays, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import (
    integral_absolute_error,
    integral_time_absolute_error,
    root_mean_square,
    seconds_since,
    white_noise,
)


def test_the_root_mean_square() -> None:
    assert root_mean_square(np.array([3.0, -4.0])) == pytest.approx(12.5**0.5)


def test_integrals_hold_each_sample_until_the_next_and_the_last_as_long_as_the_one_before() -> None:
    time_s, error = np.array([10.0, 11.0, 13.0]), np.array([-1.0, 2.0, 4.0])
    assert integral_absolute_error(time_s, error) == 1.0 + 2.0 * 2.0 + 2.0 * 4.0
    assert integral_time_absolute_error(time_s, error) == 1.0 * 2.0 * 2.0 + 3.0 * 2.0 * 4.0
    assert integral_absolute_error(time_s[:1], error[:1]) == 0.0


@pytest.mark.parametrize("slope", [0.0, 5.0])
def test_white_noise_is_found_under_motion(slope: float) -> None:
    noise = np.random.default_rng(0).normal(0.0, 0.2, 20_000)
    assert white_noise(slope * np.arange(20_000) + noise) == pytest.approx(0.2, rel=0.02)


def test_seconds_keep_nanoseconds_far_from_the_epoch() -> None:
    origin_ns = 1_700_000_000_000_000_000
    assert seconds_since(origin_ns, np.array([origin_ns + 1])).tolist() == [1e-9]
