# SPDX-License-Identifier: Apache-2.0
"""Controller and sensors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference import benchmark as reference

from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.controller import at_rest, force, observe
from fuzzy_fusion_ros.simulation.scenario import (
    ControllerParameters,
    LaggedParameters,
    WidebandParameters,
)
from fuzzy_fusion_ros.simulation.sensors import draw_noise, follow, read_s1, read_s2

DT = 0.01


def forces(parameters: ControllerParameters, estimates: list[float]) -> list[float]:
    """Feed estimates and return the force after each."""
    state = at_rest()
    found = []
    for estimate in estimates:
        state = observe(parameters, state, estimate, DT)
        found.append(force(parameters, state))
    return found


def test_the_controller_is_that_of_the_reference() -> None:
    estimates = np.cumsum(np.random.default_rng(0).normal(0.0, 0.02, 500)).tolist()
    controller = reference.Controller()
    expected = [controller.force(estimate) for estimate in estimates]
    assert forces(ControllerParameters(), estimates) == pytest.approx(expected, rel=1e-12)


def test_the_first_estimate_shows_no_derivative() -> None:
    assert forces(ControllerParameters(), [0.2]) == pytest.approx([8.0])


def test_without_a_low_pass_the_derivative_is_the_difference() -> None:
    bare = replace(ControllerParameters(), {"derivative_time_constant": 0.0})
    assert forces(bare, [0.0, 0.01]) == pytest.approx([0.0, 40.0 * 0.01 + 10.0 * 1.0])


@pytest.mark.parametrize(("estimate", "limited"), [(50.0, 100.0), (-50.0, -100.0), (2.5, 100.0)])
def test_the_force_is_limited(estimate: float, limited: float) -> None:
    assert forces(ControllerParameters(), [estimate]) == [limited]


def test_the_derivative_goes_on_behind_the_limit() -> None:
    """The limit is on the force alone: nothing winds up and nothing is forgotten."""
    steep = [0.2 * k for k in range(20)]
    controller = reference.Controller()
    expected = [controller.force(estimate) for estimate in [*steep, 0.0, 0.0]]
    assert forces(ControllerParameters(), [*steep, 0.0, 0.0]) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("angle", "noise", "expected"),
    [(0.2, 0.0, 0.17), (0.0, 1.0, 0.02), (-0.1, -2.0, -0.23)],
)
def test_s1_has_bias_and_noise(angle: float, noise: float, expected: float) -> None:
    assert read_s1(WidebandParameters(), angle, noise) == pytest.approx(expected)


@pytest.mark.parametrize(("noise", "expected"), [(0.0, 0.2), (1.0, 0.202), (-1.0, 0.198)])
def test_s2_has_noise(noise: float, expected: float) -> None:
    assert read_s2(LaggedParameters(), 0.2, noise) == pytest.approx(expected)


@pytest.mark.parametrize("dt", [0.01, 0.05, 0.2])
def test_s2_goes_its_way_to_a_step_at_any_sample_time(dt: float) -> None:
    lagged = 0.0
    for _ in range(round(0.4 / dt)):
        lagged = follow(LaggedParameters(time_constant=0.2), lagged, 1.0, dt)
    assert lagged == pytest.approx(1.0 - math.exp(-2.0))


def test_s2_without_a_time_constant_is_there_at_once() -> None:
    assert follow(LaggedParameters(time_constant=0.0), 0.0, 1.0, DT) == 1.0


def test_noise_is_standard_normal_and_independent() -> None:
    noise = draw_noise(np.random.default_rng(1), 100_000)
    assert noise.shape == (100_000, 2)
    assert noise.mean(axis=0) == pytest.approx([0.0, 0.0], abs=0.02)
    assert np.cov(noise.T).ravel() == pytest.approx([1.0, 0.0, 0.0, 1.0], abs=0.02)


def test_noise_drawn_sample_by_sample_is_the_same() -> None:
    """So a node that draws as it goes meets the noise of a run that draws it all at first."""
    at_once = draw_noise(np.random.default_rng(2), 500)
    generator = np.random.default_rng(2)
    stepwise = np.vstack([draw_noise(generator, 1) for _ in range(500)])
    one_by_one = np.random.default_rng(2)
    scalars = [one_by_one.standard_normal() for _ in range(1000)]
    assert stepwise.tobytes() == at_once.tobytes() == np.array(scalars).tobytes()
