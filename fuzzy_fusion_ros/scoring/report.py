"""Scores as tables in plain text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fuzzy_fusion_ros.scoring.metrics import METRICS
from fuzzy_fusion_ros.scoring.score import Score

DIGITS = 4


def report(scores: Sequence[Score]) -> str:
    """Return a table per recording, and one over all of them side by side if there are several."""
    parts = [f"{summary(each)}\n{table(each)}" for each in scores]
    if len(scores) > 1:
        parts.append(f"rmse, side by side\n{side_by_side(scores)}")
    return "\n\n".join(parts)


def summary(score: Score) -> str:
    """Return what was scored in a line."""
    begin, end = score.span_s
    ran = "the bag has no estimate, so the fusion ran here"
    origin = ran if score.recomputed else "the estimate is the bag's own"
    return (
        f"{score.name}: matched {score.matched} of {score.of} estimates, "
        f"{begin:.2f} s to {end:.2f} s; {origin}; baselines: {score.baselines}"
    )


def table(score: Score) -> str:
    """Return all metrics of all estimators, one estimator a row."""
    head = ["", *METRICS]
    units = ["", *(_unit(name, score.unit) for name in METRICS)]
    rows = [
        [name, *(_number(value) for value in score.scores(name).values())] for name in score.values
    ]
    return "\n".join(_aligned([head, units, *rows]))


def side_by_side(scores: Sequence[Score]) -> str:
    """Return the RMSE of all estimators, one recording a column."""
    head = ["", *(each.name for each in scores)]
    units = ["", *(_unit("rmse", each.unit) for each in scores)]
    rows = [
        [name, *(_number(each.scores(name)["rmse"]) for each in scores)]
        for name in scores[0].values
    ]
    return "\n".join(_aligned([head, units, *rows]))


def _unit(metric: str, signal: str) -> str:
    """Return the unit of a metric, nothing if it depends on one that is not known."""
    found = METRICS[metric]
    return found.unit_for(signal) if signal or "u" not in found.unit else ""


def _number(value: float) -> str:
    return f"{value:.{DIGITS}g}"


def _aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = [first.ljust(widths[0])]
        cells += [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        yield "  ".join(cells).rstrip()
