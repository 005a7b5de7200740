# SPDX-License-Identifier: Apache-2.0
"""The closed loop: plant, sensors, an estimate, the controller.

``sense`` and ``act`` are the two halves of a sample. The estimate is made between them: by a node,
or by a method in :func:`simulate`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, Stamps
from fuzzy_fusion_ros.batch.compiled import compiled, interpreted, taken_by
from fuzzy_fusion_ros.batch.series import Method, Trace, empty_trace, write
from fuzzy_fusion_ros.core.estimator import observe_s2, update
from fuzzy_fusion_ros.parameters.group import numbers
from fuzzy_fusion_ros.simulation.controller import Controller, at_rest, force, observe
from fuzzy_fusion_ros.simulation.pendulum import FALLEN, Pendulum, integrate
from fuzzy_fusion_ros.simulation.scenario import Scenario, samples_in, stamp_of
from fuzzy_fusion_ros.simulation.sensors import draw_noise, follow, read_s1, read_s2


class Loop(NamedTuple):
    """State of the loop at a sample.

    Attributes:
        k: Number of the sample, from 0.
        plant: The pendulum.
        lagged: The angle that S2 has reached, rad.
        controller: The controller.
        fallen: Whether the pendulum has fallen; the run then ends.
    """

    k: int
    plant: Pendulum
    lagged: float
    controller: Controller
    fallen: bool


class Reading(NamedTuple):
    """Both sensors at a sample, rad."""

    s1: float
    s2: float


class Run(NamedTuple):
    """A whole run; arrays of shape (n,), zero after a fall unless stated otherwise.

    Attributes:
        stamps_ns: Stamps, nanoseconds.
        truth: Angle, rad; of the full length, pi/2 after a fall.
        s1: Readings of S1, rad.
        s2: Readings of S2, rad.
        control: Force on the cart without the disturbance, N.
        trace: The estimate and its explanation.
        survived: Samples until the fall, n if there was none.
    """

    stamps_ns: Stamps
    truth: Reals
    s1: Reals
    s2: Reals
    control: Reals
    trace: Trace
    survived: int


def at_start(scenario: Scenario) -> Loop:
    """Return the loop at t = 0: S2 starts at the true angle."""
    plant = scenario.plant
    return Loop(
        k=0,
        plant=Pendulum(angle=plant.initial_angle, rate=plant.initial_rate),
        lagged=plant.initial_angle,
        controller=at_rest(),
        fallen=False,
    )


def sense(scenario: Scenario, loop: Loop, s1_noise: float, s2_noise: float) -> Reading:
    """Read both sensors, given a standard normal number for each."""
    return Reading(
        s1=read_s1(scenario.s1_sensor, loop.plant.angle, s1_noise),
        s2=read_s2(scenario.s2_sensor, loop.lagged, s2_noise),
    )


def act(scenario: Scenario, loop: Loop, estimate: float) -> tuple[float, Loop]:
    """Control on an estimate in rad, then advance by a sample time.

    Returns:
        The controller's force in N, and the loop at the next sample.
    """
    dt = scenario.sample_time
    controller = observe(scenario.controller, loop.controller, estimate, dt)
    control = force(scenario.controller, controller)
    plant = integrate(scenario.plant, loop.plant, control + disturbance_at(scenario, loop.k), dt)
    return control, Loop(
        k=loop.k + 1,
        plant=plant,
        lagged=follow(scenario.s2_sensor, loop.lagged, plant.angle, dt),
        controller=controller,
        fallen=abs(plant.angle) >= FALLEN,
    )


def disturbance_at(scenario: Scenario, k: int) -> float:
    """Return the disturbing force on the cart at sample ``k``, N."""
    t = k * scenario.sample_time
    tiny = 1e-9  # rounding of k dt must not move a sample across an edge
    if scenario.disturbance.start - tiny <= t < scenario.disturbance.end - tiny:
        return scenario.disturbance.force
    return 0.0


def simulate(
    method: Method,
    scenario: Scenario,
    generator: np.random.Generator,
    *,
    bind: Callable[..., Any] = compiled,
) -> Run:
    """Balance the pendulum on the estimates of a method.

    Args:
        method: The method, in its initial state.
        scenario: The benchmark's numbers.
        generator: Source of the sensors' noise; one per run, seeded by the caller.
        bind: Binds the loop to the method: ``compiled`` for many runs, ``interpreted`` for one.
    """
    n = samples_in(scenario)
    step_ns = round(scenario.sample_time * 1e9)
    run = Run(
        stamps_ns=stamp_of(step_ns, np.arange(n, dtype=np.int64)),
        truth=np.full(n, FALLEN),
        s1=np.zeros(n),
        s2=np.zeros(n),
        control=np.zeros(n),
        trace=empty_trace(n),
        survived=n,
    )
    bind = bind if method.compiles else interpreted
    loop = bind(_simulate, observe_s2=method.observe_s2, update=method.update)
    survived = loop(
        method.parameters,
        taken_by(loop, method.state),
        numbers(scenario),
        at_start(scenario),
        draw_noise(generator, n),
        run,
    )
    return run._replace(survived=survived)


def _simulate(
    parameters: Any, state: Any, scenario: Scenario, loop: Loop, noise: Reals, run: Run
) -> int:
    """Fill a run; ``observe_s2`` and ``update`` are ours unless bound to another method's."""
    for k in range(run.truth.size):
        if loop.fallen:
            return k
        stamp_ns = int(run.stamps_ns[k])
        reading = sense(scenario, loop, noise[k, 0], noise[k, 1])
        run.truth[k] = loop.plant.angle
        run.s1[k] = reading.s1
        run.s2[k] = reading.s2
        state = observe_s2(parameters, state, stamp_ns, reading.s2)
        estimate, state = update(parameters, state, stamp_ns, reading.s1)
        write(run.trace, k, stamp_ns, estimate)
        run.control[k], loop = act(scenario, loop, estimate.value)
    return int(run.truth.size)
