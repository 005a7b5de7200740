# SPDX-License-Identifier: Apache-2.0
"""The fuzzy aggregator against an engine of others: Takagi-Sugeno inference of simpful."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pytest

from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.parameters.fusion import (
    AggregatorParameters,
    BreakPoints,
    Drifts,
    Weights,
)

if TYPE_CHECKING:
    from simpful import FuzzySystem, LinguisticVariable


# simpful loads most of scipy and matplotlib, which each process that collects tests would wait for.
def ramp(points: BreakPoints) -> LinguisticVariable:
    """Return an input with the two complementary sets of Fig. 4."""
    from simpful import FuzzySet, LinguisticVariable

    small = FuzzySet(points=[[points.small, 1.0], [points.large, 0.0]], term="small")
    large = FuzzySet(points=[[points.small, 0.0], [points.large, 1.0]], term="large")
    return LinguisticVariable([small, large])


def table_1(parameters: AggregatorParameters) -> FuzzySystem:
    """Return the rule base in simpful's words, with product inference."""
    from simpful import FuzzySystem

    system = FuzzySystem(operators=["AND_PRODUCT"], show_banner=False)
    system.add_linguistic_variable("Difference", ramp(parameters.difference))
    system.add_linguistic_variable("Rate", ramp(parameters.rate))
    for output, levels in (("W", parameters.weight), ("Drift", parameters.drift)):
        for name, level in vars(levels).items():
            system.set_crisp_output_value(f"{output}_{name}", level)
    for difference, rate, weight, drift in (
        ("small", "small", "small", "small"),
        ("small", "large", "large", "large"),
        ("large", "small", "very_small", "small"),
        ("large", "large", "very_large", "small"),
    ):
        condition = f"IF (Difference IS {difference}) AND (Rate IS {rate})"
        system.add_rules(
            [
                f"{condition} THEN (W IS W_{weight})",
                f"{condition} THEN (Drift IS Drift_{drift})",
            ]
        )
    return system


SETTINGS = [
    AggregatorParameters(),
    AggregatorParameters(
        difference=BreakPoints(0.05, 0.4),
        rate=BreakPoints(0.2, 0.9),
        weight=Weights(0.1, 0.9, 0.4, 0.6),
        drift=Drifts(0.02, 0.3),
    ),
    AggregatorParameters(
        difference=BreakPoints(0.0, 5.0),
        rate=BreakPoints(0.5, 0.6),
        weight=Weights(1.0, 0.0, 1.0, 0.0),
        drift=Drifts(0.5, 0.0),
    ),
]


@pytest.mark.parametrize("parameters", SETTINGS)
def test_random_inputs_give_what_simpful_infers(parameters: AggregatorParameters) -> None:
    system = table_1(parameters)
    generator = np.random.default_rng(3)
    for s1, s2, rate in generator.normal(0.0, [0.3, 0.3, 1.0], (1000, 3)).tolist():
        system.set_variable("Difference", abs(s1 - s2))
        system.set_variable("Rate", abs(rate))
        inferred = system.Sugeno_inference(["W", "Drift"])
        said = aggregate(parameters, s1, s2, rate)
        assert said.weight == pytest.approx(inferred["W"], rel=1e-9, abs=1e-12)
        assert said.drift == pytest.approx(inferred["Drift"], rel=1e-9, abs=1e-12)
        moved = said.weight * s1 + (1.0 - said.weight) * s2 + np.sign(rate) * said.drift
        assert said.value == pytest.approx(moved, rel=1e-9, abs=1e-12)
