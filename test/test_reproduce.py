# SPDX-License-Identifier: Apache-2.0
"""The paper, reproduced with few seeds: the command from its arguments to its files."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from fuzzy_fusion_ros.cli.reproduce import figures_in, main
from fuzzy_fusion_ros.jobs import reproduce as job
from fuzzy_fusion_ros.jobs.reproduce import Reproduction
from fuzzy_fusion_ros.paper.checks import CheckedClaim
from fuzzy_fusion_ros.paper.methods import METHODS
from fuzzy_fusion_ros.paper.sweep import SWEEPS, points_of
from fuzzy_fusion_ros.paper.tables import FIGURES

pytestmark = pytest.mark.xdist_group("reproduce")

SEEDS = 3

HOLD = {
    (7, "S1 alone deviates highly from the zero line"),
    (8, "S2 alone oscillates"),
    (9, "the plain average is not enough"),
    (10, "without drift the response is worse than with"),
    (11, "the aggregator balances well without predictor"),
    (14, "S1 is off to the negative side on average"),
    (15, "the estimate follows the signal"),
    (16, "the predictor makes the estimate more accurate"),
    (16, "the predictor makes the response better"),
    (20, "of S2, average and fusion, fusion has the least IAE at every σ₁"),
    (21, "of S2, average and fusion, fusion has the least ITAE at every σ₁"),
    (22, "of S2, average and fusion, fusion has the least IAE at every bias₁"),
    (23, "of S2, average and fusion, fusion has the least ITAE at every bias₁"),
}
"""Claims that hold whatever the seeds."""

FAIL = {(18, "S2 alone and the average oscillate at every τ₂")}
"""Claims that fail whatever the seeds: at 0.05 s, S2 alone is a good sensor."""


class Done(NamedTuple):
    """What a run of the command left."""

    status: int
    output: Path
    document: dict[str, Any]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Done:
    """The whole of it, with few seeds."""
    return run(tmp_path_factory.mktemp("whole"), "--seeds", str(SEEDS))


def run(folder: Path, *arguments: str) -> Done:
    """Run the command and read what it wrote."""
    output, document = folder / "figures", folder / "a" / "document.json"
    status = main([*arguments, "--output", str(output), "--json", str(document)])
    return Done(status, output, json.loads(document.read_text("utf-8")))


def test_every_figure_is_there_as_picture_and_as_numbers(whole: Done) -> None:
    expected = {f"fig{number:02d}.{kind}" for number in FIGURES for kind in ("png", "csv")}
    assert {path.name for path in whole.output.iterdir()} == expected | {"contact_sheet.png"}
    assert all(path.stat().st_size > 1000 for path in whole.output.iterdir())


def test_every_method_ran_at_every_point_with_every_seed(whole: Done) -> None:
    runs = whole.document["runs"]
    keys = {(r["method"], r["tau2"], r["sigma1"], r["bias1"], r["seed"]) for r in runs}
    assert keys == {
        (method, *point, seed)
        for method in METHODS
        for point in points_of(SWEEPS)
        for seed in range(1000, 1000 + SEEDS)
    }
    assert len(runs) == len(keys)
    for each in runs:
        assert all(math.isfinite(each[name]) for name in ("iae", "itae", "rmse"))
        assert isinstance(each["fell"], bool)


def test_claims_have_the_signs_that_the_paper_gives_them(whole: Done) -> None:
    found = {(c["figure"], c["claim"]): c["holds"] for c in whole.document["claims"]}
    assert {key: found[key] for key in HOLD} == dict.fromkeys(HOLD, True)
    assert {key: found[key] for key in FAIL} == dict.fromkeys(FAIL, False)
    assert {figure for figure, _ in found} == set(FIGURES) - {6, 12, 13}


def test_intervals_hold_their_values(whole: Done) -> None:
    for check in whole.document["claims"] + whole.document["targets"]:
        low, high = check["interval"]
        assert low <= check["value"] <= high


def test_the_status_tells_whether_all_claims_hold(whole: Done) -> None:
    assert whole.status == (0 if all(c["holds"] for c in whole.document["claims"]) else 1)


@pytest.mark.slow("two more sweeps")
def test_two_runs_are_identical_whatever_the_number_of_threads(tmp_path: Path) -> None:
    """Files, too, byte by byte."""
    options = ("--figures", "8,17-19", "--seeds", "2", "--seed", "42")
    first, second = (run(tmp_path / n, *options, "--jobs", n) for n in ("1", "4"))
    assert first.document == second.document
    assert {path.name for path in first.output.iterdir()} == {
        *(f"fig{n:02d}.{kind}" for n in (8, 17, 18, 19) for kind in ("png", "csv")),
        "contact_sheet.png",
    }
    for path in first.output.iterdir():
        assert path.read_bytes() == (second.output / path.name).read_bytes()
    assert {r["seed"] for r in first.document["runs"]} == {42, 43}
    assert {r["bias1"] for r in first.document["runs"]} == {-0.03}
    assert {c["figure"] for c in first.document["claims"]} == {8, 17, 18, 19}


def test_seeds_draw_other_numbers(whole: Done, tmp_path: Path) -> None:
    other = run(tmp_path, "--figures", "9", "--seeds", "2", "--seed", "7")
    iae = {r["iae"] for r in other.document["runs"] if r["method"] == "s1"}
    assert iae.isdisjoint(r["iae"] for r in whole.document["runs"])
    assert {r["tau2"] for r in other.document["runs"]} == {0.2}
    assert other.document["targets"] == []


def test_parameters_come_from_a_file(tmp_path: Path) -> None:
    """With no drift in the parameters, the aggregator is the one without drift."""
    file = tmp_path / "driftless.yaml"
    file.write_text("fusion_node:\n  ros__parameters:\n    aggregator: {drift: {large: 0.0}}\n")
    done = run(tmp_path, "--figures", "10", "--seeds", "2", "--params", str(file))
    iae = {(r["method"], r["seed"]): r["iae"] for r in done.document["runs"]}
    for seed in (1000, 1001):
        assert iae["aggregator", seed] == iae["no_drift", seed]
    assert done.status == 1


@pytest.fixture
def canned(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., None]:
    """Let nothing be run, and these be the checked on two claims and a target."""
    monkeypatch.chdir(tmp_path)  # for the default output

    def can(*checked: bool, target: bool = True) -> None:
        claims = [CheckedClaim(9, f"claim {v}", "x > 1", v, 2.0, (1.5, 2.5), "") for v in checked]
        targets = [CheckedClaim(18, "target", "x ≤ 1", target, 2.0, (1.5, 2.5), "nominal")]
        monkeypatch.setattr(job, "reproduce", lambda *_, **__: Reproduction([], claims, targets))

    return can


@pytest.mark.parametrize(
    ("checked", "target", "status"),
    [((True, True), True, 0), ((True, False), True, 1), ((True, True), False, 0), ((), True, 0)],
)
def test_a_failed_claim_is_a_status_a_missed_target_is_not(
    canned: Callable[..., None], checked: tuple[bool, ...], target: bool, status: int
) -> None:
    canned(*checked, target=target)
    assert main([]) == status


def test_the_tables_are_printed(
    canned: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    canned(True, False, target=False)
    main([])
    printed = capsys.readouterr()
    assert "9     holds  2      1.5 … 2.5      claim True" in printed.out
    assert printed.out.count("FAILS") == 2
    assert "(x ≤ 1; nominal)" in printed.out
    assert printed.err == "reproduce: figures and the numbers behind them are in out/reproduce\n"


def test_json_on_stdout_is_alone_there(
    canned: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    canned(True)
    main(["--json", "-"])
    printed = capsys.readouterr()
    assert json.loads(printed.out)["claims"][0]["claim"] == "claim True"
    assert "claim True" in printed.err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--figures", "5"], "got '5', expected figures from 6 to 23, such as 6,9-11"),
        (["--figures", "6-99999999999"], "expected figures from 6 to 23"),
        (["--figures", "six"], "got 'six', expected figures"),
        (["--figures", "7-"], "got '7-', expected figures"),
        (["--seeds", "1"], "got '1', expected an integer from 2 to 10000"),
        (["--jobs", "0"], "got '0', expected an integer from 1"),
        (["--seed", "-3"], "expected"),
        (["--params", "/none.yaml"], "/none.yaml"),
        (["--frobnicate"], "--frobnicate"),
    ],
)
def test_unusable_arguments_are_one_line_and_status_2(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert message in printed.err


def test_an_output_that_cannot_be_written_is_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    assert main(["--figures", "6", "--seeds", "2", "--output", str(tmp_path / "file")]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "figures"),
    [("6", (6,)), ("18-23", tuple(range(18, 24))), ("11,6-8,7", (6, 7, 8, 11)), ("9-8,6", (6,))],
)
def test_lists_of_figures(text: str, figures: tuple[int, ...]) -> None:
    assert figures_in(text) == figures
