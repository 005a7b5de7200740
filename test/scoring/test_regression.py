# SPDX-License-Identifier: Apache-2.0
"""Scores against earlier ones."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fuzzy_fusion_ros.scoring.metrics import REPORTED, ScoreError
from fuzzy_fusion_ros.scoring.regression import read_scores, regressions


def document(**changes: float) -> dict[str, Any]:
    """Return a score as JSON holds it."""
    values = dict.fromkeys(REPORTED, 1.0) | {"bias": -0.1} | changes
    return {"matched": 90, "of": 100, "estimators": {"estimate": values, "s1": {"rmse": 5.0}}}


def test_the_same_is_no_regression() -> None:
    assert regressions(document(), document(), 0.0) == []


@pytest.mark.parametrize("name", REPORTED)
def test_what_got_worse_is_named(name: str) -> None:
    now = document(**{name: 1.2})
    assert [each.partition(" ")[0] for each in regressions(now, document(), 10.0)] == [name]
    assert regressions(now, document(), 200.0) == []


@pytest.mark.parametrize("name", REPORTED)
def test_what_got_better_is_fine(name: str) -> None:
    assert regressions(document(**{name: 0.05}), document(), 0.0) == []


def test_the_tolerance_is_a_share_of_what_was() -> None:
    assert regressions(document(rmse=1.0499), document(), 5.0) == []
    (problem,) = regressions(document(rmse=1.0501), document(), 5.0)
    assert problem == "rmse of the estimate: 1.0501, before 1 (+5.0%)"


def test_a_bias_near_zero_may_move_by_a_share_of_the_rmse() -> None:
    assert regressions(document(bias=0.04), document(bias=0.0), 5.0) == []
    (problem,) = regressions(document(bias=-0.06), document(bias=0.0), 5.0)
    assert problem == "bias of the estimate: 0.06, before 0 (from nothing)"


def test_fewer_matches_are_a_regression() -> None:
    now = document() | {"matched": 50}
    (problem,) = regressions(now, document(), 5.0)
    assert problem == "matched: 50.0% of the estimates, before 90.0%"


@pytest.mark.parametrize(
    ("broken", "lacks"),
    [
        ({}, "lacks 'matched' and 'of'"),
        ({"matched": 1, "of": 0}, "lacks 'matched' and 'of'"),
        ({"matched": "x", "of": 1}, "lacks 'matched' and 'of'"),
        ({"matched": 1, "of": 1}, "lacks the estimate's 'rmse'"),
        (document(itae=float("nan")), "the estimate's 'itae' is nan"),
        ({"matched": 1, "of": 1, "estimators": []}, "lacks the estimate's 'rmse'"),
    ],
)
def test_what_is_no_score_is_refused(broken: dict[str, Any], lacks: str) -> None:
    with pytest.raises(ScoreError, match=lacks):
        regressions(document(), broken, 5.0)


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "score.json"
    path.write_text(json.dumps(document()))
    assert read_scores(path) == document()


@pytest.mark.parametrize(
    ("text", "problem"), [("{", "is not JSON"), ("[1]", "is not what score --json writes")]
)
def test_other_files_are_refused(tmp_path: Path, text: str, problem: str) -> None:
    path = tmp_path / "score.json"
    path.write_text(text)
    with pytest.raises(ScoreError, match=problem):
        read_scores(path)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScoreError, match="cannot be read: No such file"):
        read_scores(tmp_path / "none.json")
