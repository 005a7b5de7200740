# SPDX-License-Identifier: Apache-2.0
"""Whole turns: the nearest value, and the one above from halfway."""

from __future__ import annotations

import math

import pytest

from fuzzy_fusion_ros.core.periodic import nearest, turns


@pytest.mark.parametrize(
    ("value", "reference", "ahead"),
    [
        (10.0, 0.0, 0),
        (180.0, 0.0, 0),
        (180.5, 0.0, 1),
        (-180.0, 0.0, -1),
        (-179.5, 0.0, 0),
        (350.0, 710.0, -1),
        (3610.0, 0.0, 10),
    ],
)
def test_a_value_is_whole_turns_ahead(value: float, reference: float, ahead: int) -> None:
    assert turns(value, reference, 360.0) == ahead
    assert nearest(value, reference, 360.0) == value - 360.0 * ahead


def test_what_is_far_apart_stays_finite() -> None:
    assert math.isfinite(nearest(1e308, -1e308, 1.0))
