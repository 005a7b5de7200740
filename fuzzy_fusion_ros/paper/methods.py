# SPDX-License-Identifier: Apache-2.0
"""The methods that the benchmark compares: the paper's and two others."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters
from fuzzy_fusion_ros.batch.series import Method, fusion
from fuzzy_fusion_ros.paper.kalman import plant_kalman
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

METHODS = (
    "ideal",
    "s1",
    "s2",
    "average",
    "no_drift",
    "aggregator",
    "complete",
    "complementary",
    "kalman",
)
"""Names of the methods, in the order of the paper's figures, then the others."""


class Contender(NamedTuple):
    """A method in the benchmark.

    Attributes:
        name: One of ``METHODS``.
        method: The method, in its initial state.
        ideal: Whether it reads an S1 without noise and bias.
    """

    name: str
    method: Method
    ideal: bool

    def with_its_sensors(self, scenario: Scenario) -> Scenario:
        """Return the scenario with the sensors that this method reads."""
        if not self.ideal:
            return scenario
        return replace(scenario, {"s1_sensor.noise": 0.0, "s1_sensor.bias": 0.0})


def contenders(parameters: Parameters) -> tuple[Contender, ...]:
    """Return all methods, in the order of ``METHODS``.

    They are the same at every point of the sweeps: the linear filters know the nominal scenario.

    Args:
        parameters: Of the fusion; each method switches drift and predictor as its name says.
    """
    nominal = Scenario()
    lag = nominal.s2_sensor.time_constant
    linear = replace(
        BaselineParameters(),
        {"complementary.time_constant": lag, "complementary.s2_lags": True},
    )
    without = {"predictor.enabled": False}
    driftless = {**without, "aggregator.drift.small": 0.0, "aggregator.drift.large": 0.0}
    made = {
        "ideal": BASELINES["s1"].method(linear),
        "s1": BASELINES["s1"].method(linear),
        "s2": BASELINES["s2"].method(linear),
        "average": BASELINES["average"].method(linear),
        "no_drift": fusion(replace(parameters, driftless)),
        "aggregator": fusion(replace(parameters, without)),
        "complete": fusion(replace(parameters, {"predictor.enabled": True})),
        "complementary": BASELINES["complementary"].method(linear),
        "kalman": plant_kalman(nominal),
    }
    return tuple(Contender(name, made[name], name == "ideal") for name in METHODS)


def warm_up(contender: Contender) -> None:
    """Compile a method in this thread, so that others do not wait for one another."""
    shortest = replace(Scenario(), {"duration": Scenario().sample_time})
    simulate(contender.method, shortest, np.random.default_rng(0))
