"""config/pendulum_conditioned.yaml: the benchmark does not feel S1's bias."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fuzzy_fusion_ros.batch.series import fusion
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

CONFIG = Path(__file__).resolve().parents[2] / "config" / "pendulum_conditioned.yaml"

BIASES = (-0.10, -0.06, -0.03, 0.0, 0.03, 0.06, 0.10)
"""Those of the benchmark's sweep, rad."""

SEEDS = range(4)


def mean_iae(parameters: Parameters, bias: float) -> float:
    """Return the mean over seeds of the time integral of the angle's magnitude, rad s."""
    scenario = replace(Scenario(), {"s1_sensor.bias": bias})
    runs = [simulate(fusion(parameters), scenario, np.random.default_rng(seed)) for seed in SEEDS]
    return float(np.mean([np.abs(run.truth).sum() * scenario.sample_time for run in runs]))


def test_every_bias_of_the_sweep_costs_at_most_a_tenth() -> None:
    parameters = parameters_from(CONFIG)
    without_bias = mean_iae(parameters, 0.0)
    for bias in BIASES:
        assert mean_iae(parameters, bias) <= 1.1 * without_bias


def test_the_paper_s_method_does_feel_it() -> None:
    plain = Parameters()
    assert mean_iae(plain, 0.1) > 1.1 * mean_iae(plain, 0.0)


def test_only_conditioning_is_not_at_its_default() -> None:
    plain = flatten(Parameters())
    changed = {
        name for name, value in flatten(parameters_from(CONFIG)).items() if value != plain[name]
    }
    assert changed == {
        "s1.lowpass_time_constant",
        "s1.bias_time_constant",
        "s1.bias_moving_share",
        "s2.lag_time_constant",
    }
