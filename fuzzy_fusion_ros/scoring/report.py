# SPDX-License-Identifier: Apache-2.0
"""Scores as tables in plain text."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from fuzzy_fusion_ros.online.mode_shares import in_words
from fuzzy_fusion_ros.scoring.metrics import METRICS, SURENESS, longest_lag
from fuzzy_fusion_ros.scoring.score import Score
from fuzzy_fusion_ros.text.table import WIDTH, number_column, text_table
from fuzzy_fusion_ros.text.visible import visible

BEST_BASELINE = "+"
"""Marks the best baseline of a recording: the one to beat."""

SURENESS_TITLE = "how far their own standard deviations hold"


def report(score: Score, metrics: Sequence[str] = tuple(METRICS)) -> str:
    """Return what there is to say of a recording, with a table of all estimators.

    Args:
        score: The recording.
        metrics: Names of the metrics to show.
    """
    tables = [summary(score), table(score, metrics)]
    if score.deviations:
        tables += [f"{SURENESS_TITLE}:", sureness(score)]
    return "\n".join(tables)


def sureness(score: Score) -> str:
    """Return how far errors are within the standard deviation of those that know theirs."""
    return text_table(sureness_cells(score), align="l" + "r" * len(SURENESS))


def sureness_cells(score: Score) -> list[tuple[str, ...]]:
    """Return the same as the rows of a table, below one of headers."""
    rows = [("", *SURENESS)]
    for name in score.deviations:
        found = score.scores(name, SURENESS)
        rows.append((name, *(f"{found[each]:.3g}" for each in SURENESS)))
    return rows


def summary(score: Score) -> str:
    """Return the name of the recording and, below it, what was scored."""
    return f"{visible(score.name)}\n{textwrap.fill(outline(score), WIDTH)}"


def outline(score: Score) -> str:
    """Return what was scored, in one paragraph."""
    begin, end = score.span_s
    origin = "computed here, as the bag has none" if score.recomputed else "from the bag"
    return (
        f"{score.matched} of {score.of} estimates matched to the truth, {begin:.2f} s to "
        f"{end:.2f} s; estimate: {origin}; baselines: {score.baselines}; "
        f"the best of them is marked {BEST_BASELINE}; modes: {in_words(score.modes)}"
    )


def table(score: Score, metrics: Sequence[str] = tuple(METRICS)) -> str:
    """Return metrics of all estimators as a table in plain text; see :func:`cells`."""
    return text_table(cells(score, metrics), headers=2)


def cells(score: Score, metrics: Sequence[str] = tuple(METRICS)) -> list[tuple[str, ...]]:
    """Return metrics of all estimators, one estimator a row, the best of each column marked.

    Args:
        score: The recording.
        metrics: Names of the metrics to show.

    Returns:
        The rows of a table, below two rows of headers: names and units. ``>2`` is a lag that is at
        least as long as the longest one tried.
    """
    scores = {name: score.scores(name, metrics) for name in score.values}
    best = score.best_baseline
    columns = [["", "", *(f"{each} {BEST_BASELINE}" if each == best else each for each in scores)]]
    for metric in metrics:
        values = [each[metric] for each in scores.values()]
        column = number_column(metric, _unit(metric, score.unit), values)
        if metric == "lag":
            column[2:] = _lags(column[2:], values, longest_lag(score.time_s))
        columns.append(column)
    return _rows(columns)


def _lags(texts: Sequence[str], values: Sequence[float], longest: float) -> list[str]:
    """Return lags as texts, with those where the search ended as what they are longer than."""
    return [
        f"{'<' if value < 0.0 else '>'}{text}" if abs(value) >= longest > 0.0 else text
        for text, value in zip(texts, values, strict=True)
    ]


def _rows(columns: Sequence[Sequence[str]]) -> list[tuple[str, ...]]:
    return list(zip(*columns, strict=True))


def _unit(metric: str, signal: str) -> str:
    """Return the unit of a metric, ``""`` if it depends on an unknown unit of the signal."""
    found = METRICS[metric]
    return found.unit_for(signal) if signal or "u" not in found.unit else ""
