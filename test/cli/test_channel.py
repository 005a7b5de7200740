# SPDX-License-Identifier: Apache-2.0
"""--channel: one channel of a parameter file, in every command that takes parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from nodes.test_channels import TOGETHER, stream, without_y, written

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.cli import check, explain, replay, score, tune
from fuzzy_fusion_ros.jobs.parameter_file import baseline_parameters
from fuzzy_fusion_ros.jobs.score import score as run_score
from fuzzy_fusion_ros.jobs.tune import tune as run_tune
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.file import dump, parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """Three axes: both sensors, and a truth that is S2's signal."""
    truths = [("/truth", at, values) for topic, at, values in stream() if topic == "/s2"]
    messages = sorted([*stream(), *truths], key=lambda each: each[1])
    return written(tmp_path / "bag", messages)


@pytest.fixture
def params(tmp_path: Path) -> Path:
    path = tmp_path / "params.yaml"
    dump(replace(Parameters(), TOGETHER), path)
    return path


def topics(path: Path) -> set[str]:
    with open_bag(path) as opened:
        return set(opened.topics)


def test_replay_runs_all_channels_or_one(bag: Path, params: Path, tmp_path: Path) -> None:
    given = [str(bag), "--params", str(params)]
    assert replay.main([*given, "--output", str(tmp_path / "all")]) == 0
    assert replay.main([*given, "--channel", "y", "--output", str(tmp_path / "y")]) == 0
    weights = {f"/fusion_node/{axis}/weight" for axis in "xyz"}
    assert topics(tmp_path / "all") & weights == weights
    assert topics(tmp_path / "y") & weights == {"/fusion_node/y/weight"}


def test_score_scores_the_channel_alone(bag: Path, params: Path, tmp_path: Path) -> None:
    given = ["--params", str(params), "--output", str(tmp_path / "new")]
    assert replay.main([str(bag), *given]) == 0
    scores = [
        run_score(
            tmp_path / "new",
            parameters=params,
            topics=Topics(channel=axis, fields={"truth": f"point.{axis}"}),
            fit_baselines=False,
        )
        for axis in "xy"
    ]
    x, y = (each.scores("estimate")["rmse"] for each in scores)
    assert 0.0 < x != y > 0.0


def test_score_leaves_out_what_the_channel_has_not_estimated(params: Path, tmp_path: Path) -> None:
    messages = list(without_y("/s1", after=80))
    truths = [("/truth", at, values) for topic, at, values in messages if topic == "/s2"]
    source = written(tmp_path / "b", sorted([*messages, *truths], key=lambda each: each[1]))
    found = {}
    for name, chosen in (("all", []), ("y", ["--channel", "y"])):
        output = tmp_path / name
        given = ["--params", str(params), *chosen, "--output", str(output)]
        assert replay.main([str(source), *given]) == 0
        topics = Topics(channel="y", fields={"truth": "point.y"})
        found[name] = run_score(output, parameters=params, topics=topics, fit_baselines=False)
    both, alone = found["all"], found["y"]
    assert 80 < both.of == alone.of < 100
    assert both.scores("estimate")["rmse"] == alone.scores("estimate")["rmse"]
    left_out = 300 - 5 - both.of
    assert (
        f"{left_out} estimates are not scored: channel y has none at their stamps, so their field "
        "is that of S2"
    ) in both.notes
    assert not any("not scored" in note for note in alone.notes)


def test_tune_keeps_the_other_channels(bag: Path, params: Path, tmp_path: Path) -> None:
    """And turns self-tuning off, which would ignore what it has fitted."""
    dump(replace(Parameters(), {**TOGETHER, "self_tuning": True}), params)
    before, output = parameters_from(params), tmp_path / "tuned.yaml"
    topics = Topics(channel="x", fields={"truth": "point.x"})
    result = run_tune(bag, output, parameters=params, topics=topics)
    tuned = parameters_from(output)
    assert tuned.channels == before.channels
    assert tuned.channel("x") != before.channel("x")
    assert not tuned.self_tuning
    for axis in "yz":
        assert tuned.channel(axis) == replace(before.channel(axis), {"self_tuning": False})
    assert baseline_parameters(output, "x") == result.baselines
    assert baseline_parameters(output, "y") is None

    again = tmp_path / "again.yaml"
    result._replace(source=output, channel="z").write(again)
    assert parameters_from(again).channel("x") == tuned.channel("x")
    assert baseline_parameters(again, "x") == baseline_parameters(again, "z") == result.baselines


@pytest.mark.parametrize("command", [check.main, explain.main, score.main, tune.main])
@pytest.mark.parametrize(
    ("channel", "problem"),
    [
        ([], "there are several channels (x, y, z): choose one with --channel"),
        (["--channel", "w"], "channels: there is no 'w', only x, y, z"),
    ],
)
def test_a_channel_has_to_be_chosen(
    bag: Path,
    params: Path,
    capsys: pytest.CaptureFixture[str],
    command: Callable[[Sequence[str]], int],
    channel: list[str],
    problem: str,
) -> None:
    at = ["--at", "1.0"] if command is explain.main else []
    assert command([str(bag), "--params", str(params), *channel, *at]) == 2
    assert problem in capsys.readouterr().err


def test_a_file_without_channels_has_none_to_choose(
    bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert replay.main([str(bag), "--channel", "x"]) == 2
    assert "channels: is empty, so there is no channel 'x'" in capsys.readouterr().err
