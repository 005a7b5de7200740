# SPDX-License-Identifier: Apache-2.0
"""The validity gate: Fig. 5."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from reference import gate as reference

from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction, accepts, combine

FINITE = st.floats(allow_nan=False, allow_infinity=False)


def final(prediction: Prediction, aggregate: float, tolerance: float) -> float:
    """Gate as the estimator does."""
    return combine(prediction, aggregate, accepts(prediction, aggregate, tolerance))


@pytest.mark.parametrize(
    ("prediction", "aggregate", "tolerance", "accepted"),
    [
        (1.0, 1.0, 0.0, True),
        (1.0, 1.25, 0.25, True),
        (1.25, 1.0, 0.25, True),
        (1.0, 1.5, 0.25, False),
        (-1.0, 1.0, 1.9, False),
        (-1.0, 1.0, 2.0, True),
        (1.7e308, -1.7e308, 1e9, False),
    ],
)
def test_a_prediction_within_the_tolerance_is_accepted(
    prediction: float, aggregate: float, tolerance: float, accepted: bool
) -> None:
    assert accepts(Prediction(True, prediction), aggregate, tolerance) is accepted


@pytest.mark.parametrize("aggregate", [0.0, 0.3, 1e300])
def test_no_prediction_is_never_accepted(aggregate: float) -> None:
    """Not even where FA happens to say what an absent prediction holds."""
    assert not accepts(NO_PREDICTION, aggregate, 1e9)
    assert final(NO_PREDICTION, aggregate, 1e9) == aggregate


def test_both_count_the_same() -> None:
    assert combine(Prediction(True, 1.0), 2.0, True) == 1.5


@given(st.none() | FINITE, FINITE, st.floats(0.0, 1e9))
def test_the_final_estimate_is_what_the_reference_says(
    prediction: float | None, aggregate: float, tolerance: float
) -> None:
    given_ = NO_PREDICTION if prediction is None else Prediction(True, prediction)
    exact = reference.final(prediction, aggregate, tolerance)
    assert final(given_, aggregate, tolerance) == pytest.approx(exact, rel=1e-15, abs=1e-300)


@given(FINITE, FINITE)
@example(1.7e308, 1.7e308)
@example(-1.7976931348623157e308, -1.7976931348623157e308)
def test_the_mean_lies_between_its_parts(prediction: float, aggregate: float) -> None:
    mean = combine(Prediction(True, prediction), aggregate, True)
    tiny = 5e-324  # halves of the smallest numbers round
    assert min(prediction, aggregate) - tiny <= mean <= max(prediction, aggregate) + tiny
