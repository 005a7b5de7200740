# SPDX-License-Identifier: Apache-2.0
"""What the paper's Figs 6-23 show, as columns of numbers."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.paper.methods import METHODS
from fuzzy_fusion_ros.paper.results import Results
from fuzzy_fusion_ros.paper.sweep import elapsed, sweep_points
from fuzzy_fusion_ros.parameters.writing import writing
from fuzzy_fusion_ros.simulation.closed_loop import Run

Table = Mapping[str, NDArray[Any]]
"""Columns of one length by their names, which end in the unit."""

RESPONSES = {
    6: "ideal",
    7: "s1",
    8: "s2",
    9: "average",
    10: "no_drift",
    11: "aggregator",
    16: "complete",
}
"""The method whose response a figure shows."""

INSIDE = {12: "aggregator", 13: "aggregator", 14: "aggregator", 15: "aggregator", 17: "complete"}
"""The method whose signals a figure shows."""


class SweepFigure(NamedTuple):
    """A figure of a sweep: a quantity of the outcomes over what is swept."""

    swept: str
    quantity: str


SWEPT = {
    18: SweepFigure("tau2", "iae"),
    19: SweepFigure("tau2", "itae"),
    20: SweepFigure("sigma1", "iae"),
    21: SweepFigure("sigma1", "itae"),
    22: SweepFigure("bias1", "iae"),
    23: SweepFigure("bias1", "itae"),
}

FIGURES = tuple(sorted([*RESPONSES, *INSIDE, *SWEPT]))
"""Numbers of all figures."""


def table_of(figure: int, runs: Mapping[str, Run], results: Results) -> Table:
    """Return what a figure shows.

    Args:
        figure: Its number.
        runs: For a figure over time: a run of its method and of ``ideal``, by method.
        results: For a figure over a sweep: all of the sweep.
    """
    if figure in SWEPT:
        return sweep_table(results, SWEPT[figure])
    if figure in RESPONSES:
        return response_table(runs[RESPONSES[figure]], runs["ideal"])
    return inside_table(figure, runs[INSIDE[figure]])


def response_table(run: Run, ideal: Run) -> Table:
    """Return the angle over time, with that of the ideal sensor unless the run is its own."""
    ideal_angle = {} if run is ideal else {"ideal_rad": ideal.truth}
    return {"time_s": elapsed(run), "angle_rad": run.truth, **ideal_angle}


def inside_table(figure: int, run: Run) -> Table:
    """Return the signals of a run over time, up to a fall."""
    alive = slice(run.survived)
    trace = run.trace
    s1, s2, weight = run.s1[alive], run.s2[alive], trace.weight[alive]
    angle = {"time_s": elapsed(run)[alive], "angle_rad": run.truth[alive]}
    if figure == 12:
        return {"time_s": angle["time_s"], "weight_1": weight}
    if figure == 13:
        added = trace.aggregate[alive] - (weight * s1 + (1.0 - weight) * s2)
        return {"time_s": angle["time_s"], "drift_rad": trace.drift[alive], "added_rad": added}
    if figure == 14:
        return {**angle, "s1_rad": s1, "s2_rad": s2}
    if figure == 15:
        return {**angle, "estimate_rad": trace.value[alive]}
    predicted = trace.predicted[alive]
    return {
        **angle,
        "aggregate_rad": trace.aggregate[alive],
        "prediction_rad": np.where(predicted, trace.prediction[alive], np.nan),
        "rejected": predicted & ~trace.accepted[alive],
    }


def sweep_table(results: Results, figure: SweepFigure) -> Table:
    """Return means and 95 % intervals, one row per method and point."""
    rows = []
    for method in METHODS:
        for point in sweep_points(figure.swept):
            values = results.values(figure.quantity, method, point)
            fell = int(results.values("fell", method, point).sum())
            interval = results.mean(figure.quantity, method, point)
            at = getattr(point, figure.swept)
            rows.append((method, at, *interval, fell, values.size))
    names = ("method", figure.swept, "mean", "low", "high", "fell", "runs")
    return {
        name: np.array(column) for name, column in zip(names, zip(*rows, strict=True), strict=True)
    }


def write_csv(table: Table, path: Path) -> None:
    """Write a table; numbers have all their digits, NaN is an empty field.

    Raises:
        FusionError: The file cannot be written.
    """
    columns = [[_text(value) for value in column.tolist()] for column in table.values()]
    with writing(path), path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(table)
        writer.writerows(zip(*columns, strict=True))


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return "" if value != value else repr(value)
    return str(value)
