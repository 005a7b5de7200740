# SPDX-License-Identifier: Apache-2.0
"""Table 1 in the words of other libraries, at this package's default parameters."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Callable

import numpy as np

from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters, BreakPoints

Inference = Callable[[float, float], tuple[float, float]]
"""Takes difference and rate; returns weight and drift."""

RULES = (
    ("small", "small", "small", "small"),
    ("small", "large", "large", "large"),
    ("large", "small", "very_small", "small"),
    ("large", "large", "very_large", "small"),
)
"""Difference and rate, then weight and drift."""

RANGE = 3.0
"""Inputs reach from 0 to here in scikit-fuzzy, which samples its sets."""


def in_simpful(parameters: AggregatorParameters) -> Inference:
    """Return Takagi-Sugeno inference of simpful."""
    from simpful import FuzzySet, FuzzySystem, LinguisticVariable

    def ramp(points: BreakPoints) -> LinguisticVariable:
        falls = FuzzySet(points=[[points.small, 1.0], [points.large, 0.0]], term="small")
        rises = FuzzySet(points=[[points.small, 0.0], [points.large, 1.0]], term="large")
        return LinguisticVariable([falls, rises])

    system = FuzzySystem(operators=["AND_PRODUCT"], show_banner=False)
    system.add_linguistic_variable("Difference", ramp(parameters.difference))
    system.add_linguistic_variable("Rate", ramp(parameters.rate))
    with contextlib.redirect_stdout(io.StringIO()):  # it says what kind of system this makes
        for output, levels in (("W", parameters.weight), ("Drift", parameters.drift)):
            for name, level in vars(levels).items():
                system.set_crisp_output_value(f"{output}_{name}", level)
    for difference, rate, weight, drift in RULES:
        condition = f"IF (Difference IS {difference}) AND (Rate IS {rate})"
        system.add_rules([f"{condition} THEN (W IS W_{weight})"])
        system.add_rules([f"{condition} THEN (Drift IS Drift_{drift})"])

    def infer(difference: float, rate: float) -> tuple[float, float]:
        system.set_variable("Difference", difference)
        system.set_variable("Rate", rate)
        inferred = system.Sugeno_inference(["W", "Drift"])
        return inferred["W"], inferred["Drift"]

    return infer


def in_scikit_fuzzy(parameters: AggregatorParameters) -> Inference:
    """Return Mamdani inference of scikit-fuzzy, which has no singletons: narrow triangles."""
    from skfuzzy import control, trimf

    inputs = {}
    for name, points in (("difference", parameters.difference), ("rate", parameters.rate)):
        variable = control.Antecedent(np.linspace(0.0, RANGE, 301), name)
        grade = np.clip(
            (variable.universe - points.small) / (points.large - points.small), 0.0, 1.0
        )
        variable["small"], variable["large"] = 1.0 - grade, grade
        inputs[name] = variable
    outputs = {}
    for name, levels in (("weight", parameters.weight), ("drift", parameters.drift)):
        variable = control.Consequent(np.linspace(-0.1, 1.1, 241), name)
        for term, level in vars(levels).items():
            variable[term] = trimf(variable.universe, [level - 0.01, level, level + 0.01])
        outputs[name] = variable
    simulation = control.ControlSystemSimulation(
        control.ControlSystem(
            [
                control.Rule(
                    inputs["difference"][difference] & inputs["rate"][rate],
                    (outputs["weight"][weight], outputs["drift"][drift]),
                    and_func=np.multiply,
                )
                for difference, rate, weight, drift in RULES
            ]
        )
    )

    def infer(difference: float, rate: float) -> tuple[float, float]:
        simulation.input["difference"] = difference
        simulation.input["rate"] = rate
        simulation.compute()
        return simulation.output["weight"], simulation.output["drift"]

    return infer
