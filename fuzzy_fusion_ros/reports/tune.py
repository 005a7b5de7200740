# SPDX-License-Identifier: Apache-2.0
"""The page of ``tune --report``."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fuzzy_fusion_ros.batch.series import Series, held_s2, seconds, trace_at_s1
from fuzzy_fusion_ros.core.estimator import WAITING
from fuzzy_fusion_ros.messages.outputs import DEVIATION, RULES
from fuzzy_fusion_ros.online.mode_shares import shares_of
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES
from fuzzy_fusion_ros.reports.charts import charts
from fuzzy_fusion_ros.reports.page import Line, Page, Table, shares
from fuzzy_fusion_ros.reports.rules import rule_base
from fuzzy_fusion_ros.text.visible import visible
from fuzzy_fusion_ros.tuning import Tuned
from fuzzy_fusion_ros.tuning.report import candidates, described, error_title, outcome


def tune_page(
    tuned: Tuned,
    series: Series,
    unit: str,
    name: str,
    origin: str,
    source: str,
    of_several: bool = False,
) -> Page:
    """Return the page of a fit.

    Args:
        tuned: The fit.
        series: What it was made to, or one of several recordings.
        unit: Unit of the signal, ``""`` where it is not known.
        name: The bag, or which excerpt of it the series is.
        origin: Bag, span and seed, in words.
        source: The parameters as a file.
        of_several: Whether the fit was made to several recordings, and so the errors of candidates
            are over all of them.
    """
    before, after = (trace_at_s1(each, series) for each in (tuned.before, tuned.parameters))
    fused = after.mode != WAITING
    target = NAMES["truth"] if tuned.with_truth else "reference"
    lines = (
        Line("s1", NAMES["s1"], COLOURS["s1"], width=1.0),
        Line("s2", NAMES["s2"], COLOURS["s2"], steps=True, width=2.0),
        Line("before", "estimate before", COLOURS["average"]),
        Line("estimate", "estimate after", COLOURS["estimate"]),
        Line("truth", target, COLOURS["truth"], width=1.0),
    )
    behind = {"weight": shares(after.weight), "drift": after.drift}
    if after.standard_deviation.any():
        behind[DEVIATION] = after.standard_deviation
    behind |= zip(RULES, shares(after.strengths.T), strict=True)
    rows = candidates(tuned)
    title = f"{error_title(tuned, unit)}{', all recordings' if of_several else ''}"
    return Page(
        title=f"fit to {visible(Path(name).name)}",
        lead=f"{origin}. {outcome(tuned, unit)}",
        notes=(),
        tables=[Table(title, rows[:1], rows[1:])],
        facts=described(tuned.sensors, unit),
        modes=shares_of(*(each[fused].tolist() for each in (after.mode, after.stamp_ns))),
        time_s=seconds(series)[0],
        series={
            "s1": series.s1,
            "s2": held_s2(series),
            "before": before.known(before.value),
            "estimate": after.known(after.value),
            "truth": np.where(tuned.counted, tuned.target, np.nan),
            **{name: after.known(values) for name, values in behind.items()},
        },
        charts=charts(lines, unit, behind),
        rules=rule_base(tuned.parameters, unit),
        parameters=source,
    )
