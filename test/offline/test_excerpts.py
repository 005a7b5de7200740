# SPDX-License-Identifier: Apache-2.0
"""Excerpts of a long recording are what it holds there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag.recorded import read, swing, write_scalars

from fuzzy_fusion_ros.batch.series import held_s2
from fuzzy_fusion_ros.offline import excerpts as module
from fuzzy_fusion_ros.offline.excerpts import excerpts
from fuzzy_fusion_ros.offline.recording import Recording


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recording:
    """One of 2000 samples of S1 and 200 of S2, which is long here."""
    monkeypatch.setattr(module, "MOST", 400)
    monkeypatch.setattr(module, "EXCERPTS", 4)
    monkeypatch.setattr(module, "FEWEST_S2", 12)
    return read(write_scalars(tmp_path / "bag", swing(20.0, estimate=False)))


def test_a_short_recording_is_taken_whole(recording: Recording) -> None:
    short = recording._replace(
        series=recording.series._replace(
            s1_ns=recording.series.s1_ns[:400], s1=recording.s1.values[:400]
        )
    )
    (whole,) = excerpts(short)
    assert whole is short


def test_excerpts_are_spread_and_hold_what_the_recording_holds_there(recording: Recording) -> None:
    found = excerpts(recording)
    whole, held = recording.series, held_s2(recording.series)
    assert [each.series.s1.size for each in found] == [120] * 3  # 12 of S2, and no more than 400
    at = [int(np.searchsorted(whole.s1_ns, each.series.s1_ns[0])) for each in found]
    assert at[0] == 0
    assert at[-1] == pytest.approx(2000 - 120, abs=1)
    assert np.ptp(np.diff(at)) <= 1
    for begin, each in zip(at, found, strict=True):
        own = each.series
        assert own.s1.tolist() == whole.s1[begin : begin + 120].tolist()
        there = own.s2_known > 0
        assert there.sum() >= 109  # until the first S2 of the excerpt there is none
        assert held_s2(own)[there].tolist() == held[begin : begin + 120][there].tolist()
        assert own.s2.size == own.s2_known[-1]
        assert each.truth.stamps_ns[0] <= own.s1_ns[0]
        assert own.s1_ns[-1] <= each.truth.stamps_ns[-1]
        assert each.truth.stamps_ns.size <= 122
        assert own.s1.base is None
    assert "2,000 samples of S1: the fit is to 3 excerpts of 120" in found[0].notes[-1]
    assert not any(each.notes for each in found[1:])


def test_excerpts_are_where_the_truth_is(recording: Recording) -> None:
    track = recording.truth
    late = recording._replace(truth=type(track)._make(each[1000:1900] for each in track))
    for each in excerpts(late):
        assert late.truth.stamps_ns[0] <= each.series.s1_ns[0]
        assert each.series.s1_ns[-1] <= late.truth.stamps_ns[-1]
    short = recording._replace(truth=type(track)._make(each[200:500] for each in track))
    (span,) = excerpts(short)
    assert span.series.s1.size == pytest.approx(300, abs=2)
    assert span.series.s1_ns[0] == pytest.approx(short.truth.stamps_ns[0], abs=2e7)
    assert "the fit is to 299 of them" in span.notes[-1]
    none = recording._replace(truth=type(track)._make(each[:1] for each in track))
    assert excerpts(none) == [none]


def test_excerpts_of_a_slow_s2_are_fewer(
    recording: Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "FEWEST_S2", 1000)
    (one,) = excerpts(recording)
    assert one.series.s1.size == 400
