# SPDX-License-Identifier: Apache-2.0
"""The charts of both pages: the signal, its errors, and the rules behind the estimate."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType

import numpy as np

from fuzzy_fusion_ros.batch.arrays import CONSTANT, Reals
from fuzzy_fusion_ros.messages.outputs import DEVIATION, RULES
from fuzzy_fusion_ros.plots.names import COLOURS
from fuzzy_fusion_ros.reports.page import Chart, Line

RULE_COLOURS = MappingProxyType(
    dict(zip(RULES, ("#0072B2", "#56B4E9", "#E69F00", "#D55E00"), strict=True))
)

AGAINST = "truth"
"""The series that errors are taken from."""


def charts(lines: Collection[Line], unit: str, behind: Mapping[str, Reals]) -> tuple[Chart, ...]:
    """Return the charts over time.

    Args:
        lines: What is drawn in the unit of the signal, with the truth among it.
        unit: Unit of the signal, ``""`` where it is not known.
        behind: What is known behind the estimate by name: weight, drift, firing strengths and its
            standard deviation. What is constant is not drawn.
    """
    compared = [line for line in lines if line.series != AGAINST]
    errors = [line._replace(minus=AGAINST, width=1.0) for line in compared]
    band = DEVIATION if DEVIATION in behind else ""
    title = "error, and the estimate's standard deviation" if band else "error"
    found = [
        Chart("signal", "signal", unit, tuple(lines), height=300),
        Chart("errors", title, unit, tuple(errors), height=200, band=band),
    ]
    if _moves(behind, "weight"):
        line = Line("weight", "weight", COLOURS["estimate"])
        found.append(Chart("weight", "W1, the weight of S1", "", (line,), 130, shares=True))
    if _moves(behind, "drift"):
        line = Line("drift", "drift", COLOURS["estimate"])
        found.append(Chart("drift", "drift", unit, (line,), 130))
    if behind.keys() >= set(RULES):
        strengths = [Line(name, _in_words(name), RULE_COLOURS[name]) for name in RULES]
        found.append(Chart("strengths", "firing strengths", "", tuple(strengths), shares=True))
    return tuple(found)


def _moves(series: Mapping[str, Reals], name: str) -> bool:
    return bool(np.ptp(series.get(name, 0.0)) > CONSTANT)


def _in_words(rule: str) -> str:
    return rule.replace("_", " ").replace(" rate", ", rate")
