# SPDX-License-Identifier: Apache-2.0
"""No command writes over what it reads."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from bag.making import points, write_bag
from faults.commands import ended

from fuzzy_fusion_ros.cli import replay, reproduce, score, tune

Main = Callable[[Sequence[str]], int]

WRITTEN: list[tuple[Main, list[str], str]] = [
    (score.main, ["bag"], "--json"),
    (score.main, ["other.mcap", "bag"], "--json"),
    (score.main, ["bag"], "--plot"),
    (score.main, ["bag"], "--report"),
    (tune.main, ["bag"], "--output"),
    (tune.main, ["bag"], "--json"),
    (tune.main, ["bag"], "--plot"),
    (tune.main, ["bag"], "--report"),
]
INPUTS = ["bag/bag_0.mcap", "bag/metadata.yaml", "parameters.yaml", "scores.json"]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current directory, with a bag, another one, parameters and scores."""
    monkeypatch.chdir(tmp_path)
    messages = points(300, ["/s1", "/s2", "/truth"])
    write_bag(tmp_path / "bag", messages)
    write_bag(tmp_path / "other", messages).rename("other.mcap")
    Path("parameters.yaml").write_text("fusion_node:\n  ros__parameters:\n    s1.field: point.x\n")
    Path("scores.json").write_text("{}\n")
    return tmp_path


def contents(folder: Path) -> dict[str, bytes]:
    """Return all files below a folder."""
    files = (each for each in folder.rglob("*") if each.is_file())
    return {str(each.relative_to(folder)): each.read_bytes() for each in files}


@pytest.mark.parametrize("link", [None, os.link, os.symlink])
@pytest.mark.parametrize("source", INPUTS)
@pytest.mark.parametrize(("main", "bags", "option"), WRITTEN)
def test_an_input_is_not_written_over(
    here: Path,
    main: Main,
    bags: list[str],
    option: str,
    source: str,
    link: Callable[[str, str], None] | None,
) -> None:
    if option == "--report" and link is None:
        return  # its suffix is none of a report's
    if main is tune.main and source == "scores.json":
        source = "bag/bag_0.mcap"  # which tune reads
    target = source
    if link is not None:
        target = "a.html" if option == "--report" else "a.png"
        link(str(here / source), target)
    before = contents(here)
    arguments = [*bags, "--params", "parameters.yaml", option, target]
    arguments += ["--baseline", "scores.json"] if main is score.main else []
    done = ended(main, arguments)
    assert (done.status, done.stdout) == (2, "")
    assert f"{target!r} is read from" in done.stderr
    assert contents(here) == before


def test_the_plot_of_one_of_several_bags_is_no_input(here: Path) -> None:
    os.link("other.mcap", "p_other.png")
    done = ended(score.main, ["bag", "other.mcap", "--plot", "p.png"])
    assert done.status == 2
    assert "p_other.png' is read from 'other.mcap'" in done.stderr


def test_a_bag_is_not_replayed_onto_an_input(here: Path) -> None:
    os.symlink("bag", "link")
    before = contents(here)
    for target in ("bag", "link", "bag/bag_0.mcap", "parameters.yaml"):
        done = ended(replay.main, ["bag", "--params", "parameters.yaml", "--output", target])
        assert done.status == 2
        assert contents(here) == before


@pytest.mark.parametrize("name", ["fig06.csv", "fig06.png", "contact_sheet.png"])
def test_a_figure_is_not_drawn_over_the_parameters(here: Path, name: str) -> None:
    Path("parameters.yaml").rename(name)
    before = contents(here)
    given = ["--figures", "6", "--seeds", "2", "--params", name, "--output", "."]
    for arguments in ([*given], [*given, "--json", name]):
        done = ended(reproduce.main, arguments)
        assert (done.status, done.stdout) == (2, "")
        assert f"is read from {name!r}" in done.stderr
        assert contents(here) == before
