# SPDX-License-Identifier: Apache-2.0
"""The controller: proportional-derivative with a filtered derivative and a limit."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.simulation.scenario import ControllerParameters


class Controller(NamedTuple):
    """State of the controller: the last estimate in rad and its filtered derivative in rad/s."""

    started: bool
    estimate: float
    derivative: float


def at_rest() -> Controller:
    """Return the controller before its first estimate."""
    return Controller(started=False, estimate=0.0, derivative=0.0)


def observe(
    parameters: ControllerParameters, state: Controller, estimate: float, dt: float
) -> Controller:
    """Take in an estimate; at the first one the derivative is 0."""
    difference = (estimate - state.estimate) / dt if state.started else 0.0
    gain = lag_gain(dt, parameters.derivative_time_constant)
    return Controller(
        started=True,
        estimate=estimate,
        derivative=state.derivative + gain * (difference - state.derivative),
    )


def force(parameters: ControllerParameters, state: Controller) -> float:
    """Return the force on the cart in N, within the limit."""
    wanted = parameters.proportional * state.estimate + parameters.derivative * state.derivative
    return min(max(wanted, -parameters.limit), parameters.limit)
