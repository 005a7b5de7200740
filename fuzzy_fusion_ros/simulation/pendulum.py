# SPDX-License-Identifier: Apache-2.0
"""The plant: an inverted pendulum on a cart, cart position not fed back."""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.simulation.scenario import PlantParameters

FALLEN = math.pi / 2
"""At this angle the pendulum has fallen, rad."""


class Pendulum(NamedTuple):
    """State of the plant: angle from upright in rad, angular rate in rad/s."""

    angle: float
    rate: float


def acceleration(plant: PlantParameters, angle: float, rate: float, force: float) -> float:
    """Return the angular acceleration in rad/s^2 under a force on the cart in N."""
    total = plant.cart_mass + plant.pole_mass
    sine = math.sin(angle)
    cosine = math.cos(angle)
    torque = (
        plant.gravity * sine
        - plant.pole_mass * plant.half_length * rate * rate * cosine * sine / total
        - force * cosine / total
    )
    return torque / (plant.half_length * (4.0 / 3.0 - plant.pole_mass * cosine * cosine / total))


def integrate(plant: PlantParameters, state: Pendulum, force: float, dt: float) -> Pendulum:
    """Advance by ``dt`` seconds: one classic Runge-Kutta step, the force held over it."""
    half = 0.5 * dt
    r1 = state.rate
    a1 = acceleration(plant, state.angle, r1, force)
    r2 = state.rate + half * a1
    a2 = acceleration(plant, state.angle + half * r1, r2, force)
    r3 = state.rate + half * a2
    a3 = acceleration(plant, state.angle + half * r2, r3, force)
    r4 = state.rate + dt * a3
    a4 = acceleration(plant, state.angle + dt * r3, r4, force)
    return Pendulum(
        angle=state.angle + dt / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4),
        rate=state.rate + dt / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4),
    )
