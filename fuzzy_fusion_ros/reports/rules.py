# SPDX-License-Identifier: Apache-2.0
"""The rule base as a page shows it: fuzzy sets, control surfaces, Table 1."""

from __future__ import annotations

from typing import Any

import numpy as np

from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.messages.outputs import RULES
from fuzzy_fusion_ros.parameters.fusion import BreakPoints, Parameters
from fuzzy_fusion_ros.plots.names import difference_name

GRID = 40
"""Cells of a control surface along each input."""

BEYOND = 1.25
"""How far beyond *fully large* an input is drawn."""

DIGITS = 4
"""Significant digits of what is drawn."""


def rule_base(parameters: Parameters, unit: str) -> dict[str, Any]:
    """Return the sets, the surfaces of weight and drift over both inputs, and the rules.

    With the observer the first input is the innovation of S2, and there is no drift to conclude.

    Args:
        parameters: Of the fusion.
        unit: Unit of the signal, ``""`` where it is not known.
    """
    rules, with_drift = parameters.aggregator, not observes(parameters)
    reaches = [BEYOND * ramp.large for ramp in (rules.difference, rules.rate)]
    differences, rates = (np.linspace(0.0, reach, GRID + 1).tolist() for reach in reaches)
    cells = [[aggregate(rules, d, 0.0, r) for d in differences] for r in rates]
    weight, drift = rules.weight, rules.drift
    surfaces = [
        _surface("W1, the weight of S1", "", 1.0, [[cell.weight for cell in row] for row in cells])
    ]
    most = max(drift.small, drift.large)
    if with_drift and most > 0.0:
        surfaces.append(
            _surface("drift", unit, most, [[cell.drift for cell in row] for row in cells])
        )
    difference = difference_name(observes(parameters))
    return {
        "inputs": [
            _input(difference, unit, rules.difference, reaches[0]),
            _input("|dS2/dt|", _per_second(unit), rules.rate, reaches[1]),
        ],
        "surfaces": surfaces,
        "rules": [
            {"series": name, "weight": w, "drift": d if with_drift else None}
            for name, w, d in zip(
                RULES,
                (weight.small, weight.large, weight.very_small, weight.very_large),
                (drift.small, drift.large, drift.small, drift.small),
                strict=True,
            )
        ],
    }


def _surface(title: str, unit: str, most: float, values: list[list[float]]) -> dict[str, Any]:
    rounded = [[_short(value) for value in row] for row in values]
    return {"title": title, "unit": unit, "most": most, "values": rounded}


def _input(title: str, unit: str, ramp: BreakPoints, reach: float) -> dict[str, Any]:
    values = sorted({*np.linspace(0.0, reach, GRID + 1).tolist(), ramp.small, ramp.large})
    return {
        "title": title,
        "unit": unit,
        "small": ramp.small,
        "large": ramp.large,
        "reach": reach,
        "values": [_short(x) for x in values],
        "grades": [_short(large(x, ramp)) for x in values],
    }


def _per_second(unit: str) -> str:
    return f"({unit})/s" if "/" in unit else f"{unit}/s" if unit else ""


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
