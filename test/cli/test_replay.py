# SPDX-License-Identifier: Apache-2.0
"""The command replay."""

from __future__ import annotations

import itertools
import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from bag.recorded import messages, swing, write_scalars

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.cli import score
from fuzzy_fusion_ros.cli.progress import Bars
from fuzzy_fusion_ros.cli.replay import main


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with everything."""
    return write_scalars(tmp_path / "bag", swing())


def test_a_new_bag_is_made(bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(bag), "--output", str(tmp_path / "out")]) == 0
    out, said = capsys.readouterr()
    assert out.splitlines() == [
        f"{tmp_path / 'out'}: 1050 messages copied, 500 estimates written",
        "modes: FUSED 100 % of the time",
    ]
    assert said == ""
    assert len(messages(tmp_path / "out", ["/estimate"])) == 500


def test_it_is_named_after_the_old_one(
    bag: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([str(bag)]) == 0
    assert main(["bag/bag_0.mcap"]) == 0
    assert messages(tmp_path / "bag_replay") == messages(tmp_path / "bag_0_replay")


@pytest.mark.parametrize(
    ("seconds", "kept", "whole"), [(40.0, "20.0 s", "40.0 s"), (0.4, "0.19 s", "0.39 s")]
)
def test_an_interrupt_leaves_what_came_before_and_says_how_much(
    seconds: float,
    kept: str,
    whole: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bag = write_scalars(tmp_path / "bag", swing(seconds))
    monkeypatch.setattr(Bars, "over", interrupted_half_way)
    assert main([str(bag), "--output", str(tmp_path / "out")]) == 130
    said = capsys.readouterr().err
    assert said == f"replay: interrupted: {tmp_path / 'out'} holds the first {kept} of {whole}\n"
    with open_bag(tmp_path / "out") as out:
        assert out.problems == []
        assert len(list(out.messages(["/s1"]))) == round(50.0 * seconds)


def test_an_interrupt_says_which_of_several_bags_are_complete(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [str(write_scalars(tmp_path / each, swing(4.0))) for each in "abc"]
    over, calls = Bars.over, itertools.count()

    def interrupted_in_the_second(*args: Any, **options: Any) -> Any:
        return (over if next(calls) == 0 else interrupted_half_way)(*args, **options)

    monkeypatch.setattr(Bars, "over", interrupted_in_the_second)
    out = tmp_path / "out"
    assert main([*names, "--output", str(out)]) == 130
    assert capsys.readouterr().err == (
        f"replay: interrupted: 1 of 3 bags are done ({out / 'a_replay'}); "
        f"{out / 'b_replay'} holds the first 2.0 s of 4.0 s\n"
    )
    assert sorted(each.name for each in out.iterdir()) == ["a_replay", "b_replay"]


def interrupted_half_way(
    _: Bars, blocks: Iterable[Block], *args: object, **options: object
) -> Iterator[Block]:
    """Pass on one half of the messages, then act as Ctrl-C does."""
    found = list(blocks)
    half_way_ns = (int(found[0].log_ns[0]) + int(found[-1].log_ns[-1]) + 10_000_000) // 2
    for block in found:
        yield block.chosen(block.log_ns < half_way_ns)
        if block.log_ns[-1] >= half_way_ns:
            raise KeyboardInterrupt


def test_several_bags_give_several(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = write_scalars(tmp_path / "other", swing())
    alone, both = tmp_path / "alone", tmp_path / "both"
    assert main([str(bag), "--output", str(alone)]) == 0
    bags = [str(each) for each in (bag, tmp_path / "missing", other)]
    assert main([*bags, "--output", str(both), "--jobs", "2"]) == 1
    assert "failed: " in capsys.readouterr().out
    assert messages(both / "bag_replay") == messages(alone)
    assert len(messages(both / "other_replay", ["/estimate"])) == 500
    assert sorted(each.name for each in both.iterdir()) == ["bag_replay", "other_replay"]


def test_the_new_bag_is_all_that_score_needs(bag: Path, tmp_path: Path) -> None:
    params = tmp_path / "params.yaml"
    params.write_text("fusion_node:\n  ros__parameters:\n    aggregator.weight.small: 0.9\n")
    out = tmp_path / "out"
    assert main([str(bag), "--params", str(params), "--output", str(out)]) == 0
    for arguments in ([str(out)], [str(out), "--params", str(params)]):
        assert score.main([*arguments, "--json", str(tmp_path / "score.json")]) == 0
        document = json.loads((tmp_path / "score.json").read_text())
        assert document["matched"] == 500


def test_the_estimate_can_be_written_alone(bag: Path, tmp_path: Path) -> None:
    assert main([str(bag), "--output", str(tmp_path / "all")]) == 0
    for source in (bag, tmp_path / "all"):  # with and without an old explanation
        out = tmp_path / f"{source.name}_less"
        assert main([str(source), "--output", str(out), "--no-explanation"]) == 0
        with open_bag(out) as reader:
            assert sorted(reader.topics) == ["/estimate", "/s1", "/s2", "/truth"]
        assert messages(out) == messages(tmp_path / "all", ["/estimate", "/s1", "/s2", "/truth"])


def test_options_are_passed_on(bag: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    arguments = ["--start", "1", "--end", "2", "--s2", "/truth", "--estimate", "/fused"]
    assert main([str(bag), "--output", str(out), *arguments, "--field", "s1=point.y"]) == 0
    assert len(messages(out, ["/fused"])) == 100


def test_restarts_and_losses_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    looped = [
        each._replace(log_s=each.time_s + 10.0 * loop) for loop in range(2) for each in swing()
    ]
    looped.append(looped[-2]._replace(value=float("inf"), log_s=20.0))
    bag = write_scalars(tmp_path / "bag", looped)
    assert main([str(bag), "--output", str(tmp_path / "out")]) == 0
    said = capsys.readouterr().err
    assert "replay: /s1: 1 dropped: value is not finite\n" in said
    assert "replay: timestamps jumped back once: state cleared, restarted" in said
    assert main([str(bag), f"{bag}/", "--output", str(tmp_path / "both")]) == 0
    said = capsys.readouterr().err
    assert f"replay: {bag}: /s1: 1 dropped: value is not finite\n" in said
    assert f"replay: {bag}: timestamps jumped back once: state cleared, restarted" in said


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["nothing"], "'nothing' does not exist"),
        (["BAG", "--s1", "/gyro"], "has no topic '/gyro'"),
        (["BAG", "--output", "BAG"], "exists: choose another directory"),
        (["BAG", "--rate", "2"], "--rate and --loop require --live"),
        (["BAG", "--loop"], "--rate and --loop require --live"),
        (["BAG", "--live", "--rate", "0"], "--rate: got '0'"),
        (["BAG", "--live", "--output", "x"], "--output cannot be used with --live"),
        (["BAG", "--live", "--no-explanation"], "--no-explanation cannot be used with --live"),
        (["BAG", "--start", "3", "--end", "1"], "--end must be greater than --start, got 1 and 3"),
        (["BAG", "--start", "9"], "has no message from 9 s on: its last is at 4.990 s"),
        (["BAG", "--start", "9", "--live"], "has no message from 9 s on"),
    ],
)
def test_what_cannot_be_used_is_one_line_and_status_2(
    bag: Path, arguments: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([each.replace("BAG", str(bag)) for each in arguments]) == 2
    said = capsys.readouterr().err
    assert problem in said
    assert said.startswith("replay: ")
    assert said.count("\n") == 1
