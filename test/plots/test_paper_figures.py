# SPDX-License-Identifier: Apache-2.0
"""The paper's figures show their tables, say their units, and never open a window."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.image import imread
from paper.outcomes import IAE, SEEDS, outcomes

from fuzzy_fusion_ros.paper.methods import METHODS, contenders
from fuzzy_fusion_ros.paper.results import Results
from fuzzy_fusion_ros.paper.sweep import NOMINAL, SWEEPS, Outcome, points_of, simulate_at
from fuzzy_fusion_ros.paper.tables import (
    FIGURES,
    INSIDE,
    RESPONSES,
    SWEPT,
    Table,
    table_of,
    write_csv,
)
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.plots.contact_sheet import contact_sheet
from fuzzy_fusion_ros.plots.paper_figures import draw
from fuzzy_fusion_ros.plots.style import save, styled
from fuzzy_fusion_ros.simulation.closed_loop import Run

OVER_TIME = sorted({*RESPONSES, *INSIDE})


@pytest.fixture(scope="module")
def runs() -> dict[str, Run]:
    """A nominal run of every method."""
    return {each.name: simulate_at(each, NOMINAL, 5) for each in contenders(Parameters())}


@pytest.fixture(scope="module")
def results() -> Results:
    """Made-up results of which some S2 runs fell."""

    def fallen(outcome: Outcome) -> Outcome:
        return outcome._replace(fell=outcome.method == "s2" and outcome.point.tau2 > 0.22)

    return Results(outcomes(fallen))


@pytest.fixture(scope="module")
def tables(runs: dict[str, Run], results: Results) -> dict[int, Table]:
    """What every figure shows."""
    return {figure: table_of(figure, runs, results) for figure in FIGURES}


def read(path: Path) -> dict[str, list[str]]:
    """Return the columns of a CSV file as text."""
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    return {name: [row[i] for row in rows] for i, name in enumerate(header)}


def numbers(texts: list[str]) -> list[float]:
    """Return what a column of a CSV file says, NaN for an empty field."""
    return [float(text) if text else math.nan for text in texts]


def figure_of(number: int, tables: dict[int, Table]) -> Figure:
    """Return a figure, drawn."""
    with styled():
        return draw(number, tables[number])


def title_of(figure: Figure) -> str:
    """Return the title of a figure."""
    return figure.texts[0].get_text()


def test_there_are_all_figures_from_6_to_23() -> None:
    assert tuple(range(6, 24)) == FIGURES


@pytest.mark.parametrize("number", FIGURES)
def test_a_csv_holds_every_digit_of_its_table(
    number: int, tables: dict[int, Table], tmp_path: Path
) -> None:
    write_csv(tables[number], tmp_path / "a" / "figure.csv")
    columns = read(tmp_path / "a" / "figure.csv")
    assert list(columns) == list(tables[number])
    for name, column in tables[number].items():
        if column.dtype.kind in "US":
            assert columns[name] == column.tolist()
        else:
            assert np.array_equal(numbers(columns[name]), column.astype(float), equal_nan=True)


@pytest.mark.parametrize("number", OVER_TIME)
def test_a_figure_over_time_draws_its_table(number: int, tables: dict[int, Table]) -> None:
    table = tables[number]
    whole, start, push, _ = figure_of(number, tables).axes
    drawn = [np.asarray(line.get_ydata()) for line in whole.lines]
    columns = [column for name, column in table.items() if name.endswith(("_rad", "_1"))]
    shown = sum(any(np.array_equal(y, c, equal_nan=True) for y in drawn) for c in columns)
    assert shown == {13: 1}.get(number, len(columns))
    assert start.get_xlim() == (0.0, 3.0)
    assert push.get_xlim()[0] < 25.0 < 25.1 < push.get_xlim()[1]


@pytest.mark.parametrize("number", SWEPT)
def test_a_figure_over_a_sweep_draws_means_and_intervals(
    number: int, tables: dict[int, Table]
) -> None:
    table = tables[number]
    axes, _ = figure_of(number, tables).axes
    assert axes.get_yscale() == "log"
    drawn = [np.asarray(line.get_ydata()).tolist() for line in axes.lines]
    for method in METHODS:
        mine = table["method"] == method
        assert table["mean"][mine].tolist() in drawn
    bars = np.concatenate([np.array(c.get_segments())[:, :, 1] for c in axes.collections])
    measured = table["method"] != "ideal"
    limits = np.column_stack([table["low"], table["high"]])[measured]
    assert np.sort(bars, axis=0) == pytest.approx(np.sort(limits, axis=0))


def test_a_sweep_table_has_a_row_for_each_method_and_point(tables: dict[int, Table]) -> None:
    table = tables[22]
    assert table["bias1"].tolist() == [*SWEEPS["bias1"]] * len(METHODS)
    assert table["method"].tolist() == [m for m in METHODS for _ in SWEEPS["bias1"]]
    assert set(table["runs"].tolist()) == {len(SEEDS)}
    kalman = table["mean"][table["method"] == "kalman"]
    assert kalman == pytest.approx(np.full(7, IAE["kalman"]), rel=0.02)


def test_falls_are_counted_and_shown_hollow(tables: dict[int, Table]) -> None:
    table = tables[18]
    fell = table["fell"][table["method"] == "s2"]
    assert fell.tolist() == [0, 0, 0, 0, len(SEEDS), len(SEEDS)]
    figure = figure_of(18, tables)
    hollow = [line for line in figure.axes[0].lines if line.get_markerfacecolor() == "white"]
    assert sum(np.asarray(line.get_xdata()).size for line in hollow) == 2
    assert "hollow" in title_of(figure)
    assert "hollow" not in title_of(figure_of(22, tables))


@pytest.mark.parametrize("number", FIGURES)
def test_a_figure_says_its_number_its_quantities_and_their_units(
    number: int, tables: dict[int, Table]
) -> None:
    figure = figure_of(number, tables)
    *panels, below = figure.axes
    assert title_of(figure).startswith(f"Fig. {number}: ")
    for axes in panels:
        assert axes.get_xlabel().startswith(("time, s", "time constant", "standard", "bias"))
        assert axes.get_ylabel() == "weight" or "rad" in axes.get_ylabel()
    assert below.get_legend() is not None


def test_tables_end_where_the_pendulum_falls(runs: dict[str, Run]) -> None:
    fallen = {**runs, "complete": runs["complete"]._replace(survived=1234)}
    table = table_of(17, fallen, Results([]))
    assert {column.size for column in table.values()} == {1234}


def test_the_drift_is_what_the_aggregate_has_beyond_the_weighted_mean(
    tables: dict[int, Table],
) -> None:
    table = tables[13]
    assert np.abs(table["added_rad"]) == pytest.approx(table["drift_rad"], abs=1e-12)


def test_the_gates_rejections_are_marked(runs: dict[str, Run]) -> None:
    trace = runs["complete"].trace
    accepted = trace.accepted.copy()
    accepted[2505:2515] = False
    changed = runs["complete"]._replace(trace=trace._replace(accepted=accepted))
    table = table_of(17, {**runs, "complete": changed}, Results([]))
    assert table["rejected"][2505:2515].all()
    marks = figure_of(17, {17: table}).axes[2].lines[-1]
    assert marks.get_label() == "rejected by the gate"
    inside = (table["time_s"] >= 24.5) & (table["time_s"] < 27.5)
    assert np.asarray(marks.get_xdata()).size == np.sum(table["rejected"][inside])


def test_the_same_figure_gives_the_same_bytes(tables: dict[int, Table], tmp_path: Path) -> None:
    for name in ("a.png", "b.png"):
        with styled():
            save(draw(18, tables[18]), tmp_path / name)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    assert imread(tmp_path / "a.png").shape[1] == 1800


def test_the_contact_sheet_shows_every_picture(tables: dict[int, Table], tmp_path: Path) -> None:
    pictures = [tmp_path / f"{i}.png" for i in range(4)]
    with styled():
        for picture in pictures:
            save(draw(6, tables[6]), picture)
        sheet = contact_sheet(pictures)
    assert sum(len(axes.images) for axes in sheet.axes) == 4
    assert len(sheet.axes) == 6


def test_a_table_that_cannot_be_written_is_said_so(
    tables: dict[int, Table], tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FusionError, match=r"fig06\.csv' cannot be written: "):
        write_csv(tables[6], tmp_path / "file" / "fig06.csv")


def test_only_what_a_figure_needs_is_asked_for(runs: dict[str, Run], results: Results) -> None:
    assert table_of(18, {}, results)
    nothing = Results(outcomes(points=points_of([])))
    assert table_of(7, {name: runs[name] for name in ("s1", "ideal")}, nothing)
    assert table_of(12, {"aggregator": runs["aggregator"]}, nothing)
