# SPDX-License-Identifier: Apache-2.0
"""The plant: its equation, its symmetry, its energy, and the order of its integration."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import benchmark as reference
from scipy.integrate import solve_ivp

from fuzzy_fusion_ros.simulation.pendulum import FALLEN, Pendulum, acceleration, integrate
from fuzzy_fusion_ros.simulation.scenario import PlantParameters

PLANT = PlantParameters()
ANGLE = st.floats(-FALLEN, FALLEN)
RATE = st.floats(-20.0, 20.0)
FORCE = st.floats(-100.0, 100.0)


def energy(state: Pendulum) -> float:
    """Return the energy of pole and cart in J, the cart moving so that no momentum is left."""
    share = PLANT.pole_mass / (PLANT.cart_mass + PLANT.pole_mass)
    inertia = 4.0 / 3.0 - share * math.cos(state.angle) ** 2
    motion = 0.5 * PLANT.pole_mass * PLANT.half_length**2 * inertia * state.rate**2
    height = PLANT.half_length * math.cos(state.angle)
    return motion + PLANT.pole_mass * PLANT.gravity * height


def rolled(state: Pendulum, force: float, seconds: float, steps: int) -> Pendulum:
    """Integrate in equal steps."""
    for _ in range(steps):
        state = integrate(PLANT, state, force, seconds / steps)
    return state


@given(ANGLE, RATE, FORCE)
def test_the_equation_is_that_of_the_reference(angle: float, rate: float, force: float) -> None:
    expected = reference.pendulum([angle, rate], force)[1]
    assert acceleration(PLANT, angle, rate, force) == pytest.approx(expected, rel=1e-12, abs=1e-9)


@given(ANGLE, RATE, FORCE)
def test_a_step_is_that_of_the_reference(angle: float, rate: float, force: float) -> None:
    expected = reference.runge_kutta(
        lambda state: reference.pendulum(state, force), [angle, rate], 0.01
    )
    assert integrate(PLANT, Pendulum(angle, rate), force, 0.01) == pytest.approx(
        expected, rel=1e-12, abs=1e-12
    )


@pytest.mark.parametrize(
    ("angle", "force", "expected"),
    [
        (0.0, 0.0, 0.0),
        (math.pi, 0.0, 0.0),
        (math.pi / 2, 0.0, 9.8 / (0.5 * 4.0 / 3.0)),
        (0.0, 1.1, -1.0 / (0.5 * (4.0 / 3.0 - 0.1 / 1.1))),
    ],
)
def test_accelerations_that_can_be_told_by_hand(
    angle: float, force: float, expected: float
) -> None:
    assert acceleration(PLANT, angle, 0.0, force) == pytest.approx(expected, abs=1e-14)


@given(ANGLE, RATE, FORCE)
def test_left_is_right_mirrored(angle: float, rate: float, force: float) -> None:
    right = integrate(PLANT, Pendulum(angle, rate), force, 0.01)
    left = integrate(PLANT, Pendulum(-angle, -rate), -force, 0.01)
    assert left == (-right.angle, -right.rate)


def test_upright_and_at_rest_it_stays() -> None:
    assert rolled(Pendulum(0.0, 0.0), 0.0, 10.0, 1000) == (0.0, 0.0)


@pytest.mark.parametrize("state", [Pendulum(0.2, 0.0), Pendulum(-1.0, 3.0), Pendulum(3.0, 1.0)])
def test_without_a_force_the_energy_stays(state: Pendulum) -> None:
    after = rolled(state, 0.0, 10.0, 1000)
    assert after != state
    assert energy(after) == pytest.approx(energy(state), abs=1e-5)


@pytest.mark.parametrize("force", [-20.0, 0.0, 20.0])
def test_the_integration_is_of_fourth_order(force: float) -> None:
    start = Pendulum(0.2, -0.5)
    exact = solve_ivp(
        lambda _, state: [state[1], acceleration(PLANT, state[0], state[1], force)],
        (0.0, 0.5),
        start,
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
    ).y[:, -1]
    errors = [math.dist(rolled(start, force, 0.5, steps), exact) for steps in (50, 100, 200)]
    orders = [math.log2(a / b) for a, b in itertools.pairwise(errors)]
    assert orders == pytest.approx([4.0, 4.0], abs=0.25)


def test_one_step_a_sample_is_exact_to_a_millionth() -> None:
    start = Pendulum(0.2, 1.0)
    fine = rolled(start, 30.0, 0.01, 100)
    assert math.dist(rolled(start, 30.0, 0.01, 1), fine) < 1e-6
