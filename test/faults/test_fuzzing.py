# SPDX-License-Identifier: Apache-2.0
"""Spoilt input of every kind: read, or refused with one line; never a traceback, never a hang."""

from __future__ import annotations

from pathlib import Path

import pytest

from faults import fuzzing
from faults.guided import fuzz
from faults.mutations import MUTATIONS, Original, mutated, original
from faults.streams import clean_stream
from fuzzy_fusion_ros.cli import replay, score, tune

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Original:
    """A bag that is whole."""
    return original(tmp_path_factory.mktemp("whole") / "bag")


@pytest.mark.parametrize("each_way", [2, pytest.param(10, marks=pytest.mark.slow("more of them"))])
def test_spoilt_bags(whole: Original, tmp_path: Path, each_way: int) -> None:
    outcomes = fuzzing.spoilt_bags(whole, tmp_path, range(each_way * len(MUTATIONS)))
    assert sum(outcomes.values()) == each_way * len(MUTATIONS)
    for name in MUTATIONS:
        assert outcomes[f"{name}: read"] + outcomes[f"{name}: refused"] == each_way


def test_mutations_repeat_themselves(whole: Original, tmp_path: Path) -> None:
    for seed in range(len(MUTATIONS)):
        for path in (tmp_path / "one", tmp_path / "two"):
            mutated(whole, path / "bag", seed)
        one, two = (
            {each.name: each.read_bytes() for each in (tmp_path / name / "bag").iterdir()}
            for name in ("one", "two")
        )
        assert one == two


def test_parameter_sets() -> None:
    outcomes = fuzzing.parameter_sets(clean_stream(40, 3), range(300))
    assert min(outcomes["fused"], outcomes["refused"]) > 100
    assert min(outcomes["bounded"], outcomes["channels"]) > 30


def test_parameter_files(tmp_path: Path) -> None:
    example = (ROOT / "config/fusion_node.yaml").read_text(encoding="utf-8")
    outcomes = fuzzing.parameter_files(example, tmp_path / "some.yaml", range(400))
    assert min(outcomes["read"], outcomes["refused"]) > 20


def test_field_paths() -> None:
    assert fuzzing.field_paths(range(1000))["tried"] == 1000


def test_command_lines(whole: Original, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    mains = {"replay": replay.main, "score": score.main}
    outcomes = fuzzing.command_lines(mains, whole.path, range(150))
    assert sum(outcomes.values()) == 150


@pytest.mark.slow("tune fits whenever it is not refused")
def test_command_lines_of_tune(
    whole: Original, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    outcomes = fuzzing.command_lines({"tune": tune.main}, whole.path, range(10))
    assert sum(outcomes.values()) == 10


def test_guided_by_coverage(tmp_path: Path) -> None:
    guided = fuzz(tmp_path, 150, seed=1)
    assert guided.kept > 5
    assert guided.steps > guided.first_steps
