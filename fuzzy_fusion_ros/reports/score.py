# SPDX-License-Identifier: Apache-2.0
"""The page of ``score --report``."""

from __future__ import annotations

from pathlib import Path

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.messages.outputs import DEVIATION
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES
from fuzzy_fusion_ros.reports.charts import charts
from fuzzy_fusion_ros.reports.page import Line, Page, Table, shares
from fuzzy_fusion_ros.reports.rules import rule_base
from fuzzy_fusion_ros.scoring.report import SURENESS_TITLE, cells, outline, sureness_cells
from fuzzy_fusion_ros.scoring.score import Score
from fuzzy_fusion_ros.text.visible import visible

LINES = tuple(
    Line(name, NAMES[name], COLOURS[name], steps=name == "s2", width=width)
    for name, width in (("s1", 1.0), ("s2", 2.0), ("estimate", 1.5), ("truth", 1.0))
)


def score_page(score: Score, parameters: Parameters, source: str) -> Page:
    """Return the page of a scored recording.

    Args:
        score: The recording, scored.
        parameters: Of the fusion.
        source: The parameters as a file.
    """
    rows = cells(score)
    tables = [Table("scores", rows[:2], rows[2:])]
    if score.deviations:
        rows = sureness_cells(score)
        tables.append(Table(SURENESS_TITLE, rows[:1], rows[1:]))
    series = _series(score)
    return Page(
        title=f"score of {visible(Path(score.name).name)}",
        lead=outline(score),
        notes=score.notes,
        tables=tables,
        facts=(),
        modes=score.modes,
        time_s=score.time_s,
        series=series,
        charts=charts(LINES, score.unit, series),
        rules=rule_base(parameters, score.unit),
        parameters=source,
    )


def _series(score: Score) -> dict[str, Reals]:
    series = {"truth": score.truth}
    series |= {name: score.values[name] for name in ("s1", "s2", "estimate")}
    if "estimate" in score.deviations:
        series[DEVIATION] = score.deviations["estimate"]
    for name, values in score.behind.items():
        series[name] = values if name == "drift" else shares(values)
    return series
