# SPDX-License-Identifier: Apache-2.0
"""Series at the stamps of others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.offline.tracks import Track
from fuzzy_fusion_ros.scoring.join import gap_time, held, in_gaps, interpolated

BEGIN_NS = 1_700_000_000_123_456_789


def track(times: list[int], values: list[float]) -> Track:
    """Return a track at times in ns since ``BEGIN_NS``."""
    stamps = BEGIN_NS + np.array(times, np.int64)
    return Track(stamps, np.array(values), stamps)


def test_between_two_samples_lies_the_line() -> None:
    found = interpolated(
        track([0, 100, 1000], [1.0, 3.0, 0.0]),
        BEGIN_NS + np.array([-1, 0, 25, 100, 550, 1000, 1001]),
    )
    assert np.array_equal(found, [np.nan, 1.0, 1.5, 3.0, 1.5, 0.0, np.nan], equal_nan=True)


def test_gaps_are_between_samples_only() -> None:
    stamps_ns = np.array([0, 10, 20, 500, 510], np.int64)
    wanted_ns = np.array([-5, 0, 15, 20, 21, 499, 500, 505, 600], np.int64)
    assert in_gaps(stamps_ns, wanted_ns).tolist() == [
        False,
        False,
        False,
        False,
        True,
        True,
        False,
        False,
        False,
    ]
    assert not in_gaps(stamps_ns[:1], wanted_ns).any()


def test_a_gap_counts_as_a_usual_step() -> None:
    stamps_ns = np.array([0, 10, 20, 500, 510], np.int64)
    assert gap_time(stamps_ns, np.array([5, 20, 499, 500, 600])) == pytest.approx(
        [0.0, 0.0, 0.0, 470e-9, 470e-9]
    )
    assert gap_time(stamps_ns[:1], np.array([0, 7])).tolist() == [0.0, 0.0]


def test_in_a_gap_there_is_nothing() -> None:
    found = interpolated(
        track([0, 10, 20, 500, 510], [1.0, 2.0, 3.0, 0.0, 1.0]),
        BEGIN_NS + np.array([15, 20, 260, 500, 505]),
    )
    assert np.array_equal(found, [2.5, 3.0, np.nan, 0.0, 0.5], equal_nan=True)


def test_nothing_comes_of_nothing() -> None:
    assert np.isnan(interpolated(track([], []), BEGIN_NS + np.arange(3))).all()
    assert interpolated(track([0, 1], [0.0, 1.0]), np.array([], np.int64)).size == 0


def test_a_single_sample_counts_where_it_is() -> None:
    found = interpolated(track([5], [2.0]), BEGIN_NS + np.array([4, 5, 6]))
    assert np.array_equal(found, [np.nan, 2.0, np.nan], equal_nan=True)


@given(
    times=st.lists(st.integers(0, 10**12), min_size=2, max_size=20, unique=True).map(sorted),
    data=st.data(),
)
def test_it_stays_between_the_neighbours(times: list[int], data: st.DataObject) -> None:
    values = [data.draw(st.floats(-1e3, 1e3)) for _ in times]
    wanted = data.draw(st.integers(times[0], times[-1]))
    known, at = track(times, values), np.array([BEGIN_NS + wanted])
    found = interpolated(known, at)[0]
    assert np.isnan(found) == in_gaps(known.stamps_ns, at)[0]
    after = next(k for k, time in enumerate(times) if time >= wanted)
    around = values[max(after - 1, 0) : after + 1]
    assert np.isnan(found) or min(around) - 1e-9 <= found <= max(around) + 1e-9
    if wanted in times:
        assert found == values[times.index(wanted)]


def test_a_held_value_is_the_newest() -> None:
    found = held(
        np.array([10, 20], np.int64), np.array([1.0, 2.0]), np.array([9, 10, 19, 20, 99], np.int64)
    )
    assert np.array_equal(found, [np.nan, 1.0, 1.0, 2.0, 2.0], equal_nan=True)


def test_an_empty_series_holds_nothing() -> None:
    assert np.isnan(held(np.array([], np.int64), np.array([]), np.array([1, 2]))).all()
