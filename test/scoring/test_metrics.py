# SPDX-License-Identifier: Apache-2.0
"""Tables of values for every metric, and what they refuse."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.scoring.metrics import (
    METRICS,
    REPORTED,
    SURENESS,
    Matched,
    ScoreError,
    _best_shift,
    longest_lag,
)

NAN, INF = math.nan, math.inf


def matched(errors: list[float], times_s: list[float] | None = None) -> Matched:
    """Return an estimate with these errors beside a truth that moves."""
    times = np.arange(len(errors), dtype=np.float64) if times_s is None else np.array(times_s)
    truth = np.arange(len(errors), dtype=np.float64)
    return Matched(times, truth + np.array(errors), truth)


TABLE = {
    "rmse": [([3.0], 3.0), ([-3.0, 4.0], math.sqrt(12.5)), ([0.0, 0.0], 0.0)],
    "mae": [([3.0], 3.0), ([-3.0, 4.0], 3.5), ([0.0, 0.0], 0.0)],
    "median": [([3.0], 3.0), ([-3.0, 4.0, 10.0], 4.0), ([-1.0, 3.0], 2.0)],
    "std": [([3.0], 0.0), ([-3.0, 4.0], 3.5), ([2.0, 2.0], 0.0)],
    "min": [([3.0], 3.0), ([-3.0, 4.0], 3.0), ([0.0, -1.0], 0.0)],
    "max": [([3.0], 3.0), ([-3.0, 2.0], 3.0), ([0.0, 0.0], 0.0)],
    "sse": [([3.0], 9.0), ([-3.0, 4.0], 25.0), ([0.0, 0.0], 0.0)],
    "bias": [([3.0], 3.0), ([-3.0, 4.0], 0.5), ([-2.0, -2.0], -2.0)],
    "iae": [([3.0], 0.0), ([-3.0, 4.0], 7.0), ([1.0, 1.0, 1.0], 3.0)],
    "itae": [([3.0], 0.0), ([-3.0, 4.0], 4.0), ([1.0, 1.0, 1.0], 3.0)],
    "lag": [([3.0], 0.0), ([-3.0, 4.0], 0.0), ([1.0, 1.0, 1.0], 0.0)],
}


@pytest.mark.parametrize(
    ("name", "errors", "expected"),
    [(name, errors, expected) for name, rows in TABLE.items() for errors, expected in rows],
)
def test_values(name: str, errors: list[float], expected: float) -> None:
    assert METRICS[name].function(matched(errors)) == pytest.approx(expected, abs=1e-12)


SURE = {
    "within_1sd": [([0.5, -1.0, 1.5, 3.0], 0.5), ([0.0], 1.0)],
    "within_2sd": [([0.5, -1.0, 1.5, 3.0], 0.75), ([-9.0], 0.0)],
    "nll": [
        ([0.0], 0.5 * math.log(2.0 * math.pi)),
        ([2.0, 0.0], 1.0 + 0.5 * math.log(2.0 * math.pi)),
    ],
}


@pytest.mark.parametrize(
    ("name", "errors", "expected"),
    [(name, errors, expected) for name, rows in SURE.items() for errors, expected in rows],
)
def test_how_far_a_standard_deviation_holds(
    name: str, errors: list[float], expected: float
) -> None:
    for deviation in (1.0, 4.0):  # of the same shape, whatever its size
        scaled = matched([deviation * each for each in errors])
        sure = replace(scaled, deviation=np.full(len(errors), deviation))
        found = SURENESS[name].function(sure)
        shift = math.log(deviation) if name == "nll" else 0.0
        assert found == pytest.approx(expected + shift)


def test_every_metric_has_its_rows() -> None:
    assert set(TABLE) == set(METRICS)
    assert set(SURE) == set(SURENESS)
    assert set(REPORTED) == {"rmse", "mae", "iae", "itae", "max", "bias"}


def test_integrals_follow_the_actual_times() -> None:
    data = matched([1.0, -2.0, 3.0], [10.0, 10.5, 12.0])
    assert METRICS["iae"].function(data) == pytest.approx(0.5 * 1.0 + 1.5 * 2.0 + 1.5 * 3.0)
    assert METRICS["itae"].function(data) == pytest.approx(1.5 * 2.0 * 0.5 + 1.5 * 3.0 * 2.0)


@pytest.mark.parametrize("bad", [NAN, INF, -INF])
@pytest.mark.parametrize("field", [each.name for each in fields(Matched)])
def test_what_is_not_finite_is_refused(bad: float, field: str) -> None:
    data = replace(matched([1.0, 2.0, 3.0]), deviation=np.ones(3))
    array = getattr(data, field).copy()
    array[1] = bad
    with pytest.raises(ScoreError, match="not finite"):
        replace(data, **{field: array})


def test_shapes_must_be_one() -> None:
    data = matched([1.0, 2.0])
    with pytest.raises(ScoreError, match="expected three of one"):
        replace(data, truth=np.zeros(3))
    with pytest.raises(ScoreError, match="expected three of one"):
        replace(data, deviation=np.ones(3))
    with pytest.raises(ScoreError, match="expected three of one"):
        Matched(*(np.zeros((2, 1)) for _ in range(3)))
    with pytest.raises(ScoreError, match="no sample"):
        matched([])
    with pytest.raises(ScoreError, match="do not increase"):
        replace(data, time_s=np.zeros(2))


@pytest.mark.parametrize("shift_s", [-0.33, -0.1, 0.0, 0.05, 0.137, 0.5])
def test_a_lag_is_found_between_the_samples(shift_s: float) -> None:
    times = np.arange(0.0, 30.0, 0.01)

    def signal(t: np.ndarray) -> np.ndarray:
        return np.sin(t) + 0.3 * np.sin(2.7 * t + 1.0)

    data = Matched(times, signal(times - shift_s) + 5.0, signal(times))
    assert METRICS["lag"].function(data) == pytest.approx(shift_s, abs=1e-3)


def test_a_lag_beyond_reach_is_the_reach() -> None:
    times = np.arange(0.0, 100.0, 0.01)
    data = Matched(times, np.tanh(times - 55.0), np.tanh(times - 45.0))
    assert METRICS["lag"].function(data) == longest_lag(times) == pytest.approx(2.0)


def test_a_jump_of_ten_years_hides_no_lag() -> None:
    times = np.arange(0.0, 30.0, 0.01)
    apart = times + np.where(times < 15.0, 0.0, 10 * 365.25 * 86400.0)
    found = METRICS["lag"].function(Matched(apart, np.sin(times - 0.137), np.sin(times)))
    assert found == pytest.approx(0.137, abs=0.005)


@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_the_shift_is_the_one_of_the_smallest_variance(offset: float) -> None:
    rng = np.random.default_rng(5)
    estimate = np.cumsum(rng.standard_normal(500)) + offset
    truth = estimate[37:437] + 0.1 * rng.standard_normal(400) - 3.0
    best, misfits = _best_shift(estimate - offset, truth - offset)
    windows = np.lib.stride_tricks.sliding_window_view(estimate - offset, 400)
    expected = [float(np.var(window - (truth - offset))) for window in windows]
    assert best == np.argmin(expected) == 37
    assert misfits.tolist() == expected[36:39]


def test_what_does_not_move_has_no_lag() -> None:
    times = np.arange(100.0)
    assert METRICS["lag"].function(Matched(times, np.ones(100), np.sin(times))) == 0.0


@given(
    errors=st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=50),
    scale=st.floats(1e-3, 1e3),
)
def test_all_scale_with_the_signal(errors: list[float], scale: float) -> None:
    data = matched(errors)
    scaled = Matched(data.time_s, scale * data.estimate, scale * data.truth)
    for name, metric in METRICS.items():
        power = {"sse": 2, "lag": 0}.get(name, 1)
        if name != "lag":
            assert metric.function(scaled) == pytest.approx(
                scale**power * metric.function(data), rel=1e-6, abs=1e-6
            )


@given(errors=st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=50))
def test_they_agree_with_one_another(errors: list[float]) -> None:
    value = {name: metric.function(matched(errors)) for name, metric in METRICS.items()}
    assert value["min"] <= value["median"] <= value["max"]
    assert abs(value["bias"]) <= value["mae"] + 1e-6
    assert value["mae"] <= value["rmse"] * (1.0 + 1e-9) + 1e-6
    assert value["rmse"] ** 2 == pytest.approx(
        value["bias"] ** 2 + value["std"] ** 2, rel=1e-6, abs=1e-6
    )
    assert value["sse"] == pytest.approx(len(errors) * value["rmse"] ** 2, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "signal", "expected"),
    [
        ("rmse", "rad", "rad"),
        ("rmse", "m/s^2", "m/s^2"),
        ("sse", "rad", "rad^2"),
        ("sse", "m/s^2", "(m/s^2)^2"),
        ("iae", "rad", "rad s"),
        ("itae", "m/s", "(m/s) s^2"),
        ("lag", "m/s", "s"),
    ],
)
def test_units(name: str, signal: str, expected: str) -> None:
    assert METRICS[name].unit_for(signal) == expected
