# SPDX-License-Identifier: Apache-2.0
"""A Kalman filter that knows the benchmark's plant and sensors: the value of a model.

An extended Kalman filter over angle, angular rate, the lagged angle inside S2, and S1's bias. It
knows every number of a scenario except the disturbance. The force on the cart it computes itself:
the controller is known and acts on this filter's estimates, so the filter keeps a copy of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.parameters.group import numbers
from fuzzy_fusion_ros.simulation.controller import Controller, at_rest, force, observe
from fuzzy_fusion_ros.simulation.pendulum import Pendulum, integrate
from fuzzy_fusion_ros.simulation.scenario import Scenario
from fuzzy_fusion_ros.simulation.sensors import follow

ANGLE, RATE, LAGGED, BIAS = range(4)
"""Order of the filter's state: rad, rad/s, rad, rad."""

FORCE_NOISE = 0.5
"""Standard deviation of the unknown force on the cart at each sample, N."""

RATE_SPREAD = 0.1
"""Standard deviation of the angular rate at the start, rad/s."""

BIAS_SPREAD = 1.0
"""Standard deviation of S1's bias before its first sample, rad: it is unknown."""

SMALL = 1e-6
"""Half the step of the difference quotients, in the unit of what is varied."""


class Knowledge(NamedTuple):
    """What the filter knows.

    Attributes:
        scenario: Plant, sensors, controller and sample time, as plain numbers.
        force_noise: As ``FORCE_NOISE``.
    """

    scenario: Scenario
    force_noise: float


class PlantBelief(NamedTuple):
    """State of the filter.

    Attributes:
        samples: S2 samples taken.
        mean: Shape (4,), in the order of ``ANGLE`` and so on.
        covariance: Shape (4, 4), symmetric.
        controller: Copy of the loop's controller.
    """

    samples: int
    mean: Reals
    covariance: Reals
    controller: Controller


def plant_kalman(scenario: Scenario) -> Method:
    """Return the filter for the plant and the sensors of a scenario, as a method."""
    knowledge = Knowledge(scenario=numbers(scenario), force_noise=FORCE_NOISE)
    return Method(observe_s2, update, without_s1, knowledge, no_belief())


def no_belief() -> PlantBelief:
    """Return the state before any sample."""
    return PlantBelief(
        samples=0, mean=np.zeros(4), covariance=np.zeros((4, 4)), controller=at_rest()
    )


def observe_s2(
    knowledge: Knowledge, belief: PlantBelief, stamp_ns: int, value: float
) -> PlantBelief:
    """Propagate by a sample time, then correct by a sample of S2; the first initialises.

    Args:
        knowledge: What the filter knows.
        belief: The state after the last sample.
        stamp_ns: Stamp of the sample, one sample time after the last.
        value: The sample, rad.
    """
    variance = knowledge.scenario.s2_sensor.noise**2
    if belief.samples == 0:
        mean, covariance = first_belief(value, variance)
    else:
        mean, covariance = predict(knowledge, belief)
        mean, covariance = correct(mean, covariance, row(LAGGED, LAGGED), value, variance)
    return PlantBelief(
        samples=belief.samples + 1,
        mean=mean,
        covariance=covariance,
        controller=belief.controller,
    )


def update(
    knowledge: Knowledge, belief: PlantBelief, stamp_ns: int, value: float
) -> tuple[Estimate, PlantBelief]:
    """Correct by a sample of S1, estimate the angle in rad, and control on it as the loop will."""
    variance = knowledge.scenario.s1_sensor.noise**2
    mean, covariance = correct(belief.mean, belief.covariance, row(ANGLE, BIAS), value, variance)
    controller = observe(
        knowledge.scenario.controller,
        belief.controller,
        mean[ANGLE],
        knowledge.scenario.sample_time,
    )
    estimate = estimated(mean[ANGLE], 0.0)
    return estimate, PlantBelief(
        samples=belief.samples, mean=mean, covariance=covariance, controller=controller
    )


def first_belief(s2: float, variance: float) -> tuple[Reals, Reals]:
    """Return mean and covariance after the first S2 sample: S2 starts at the true angle."""
    mean = np.zeros(4)
    covariance = np.zeros((4, 4))
    for i in (ANGLE, LAGGED):
        mean[i] = s2
        for j in (ANGLE, LAGGED):
            covariance[i, j] = variance
    covariance[RATE, RATE] = RATE_SPREAD**2
    covariance[BIAS, BIAS] = BIAS_SPREAD**2
    return mean, covariance


def without_s1(knowledge: Knowledge, belief: PlantBelief, stamp_ns: int) -> Estimate:
    """Return no estimate: in the benchmark S1 is never lost."""
    return waiting()


def predict(knowledge: Knowledge, belief: PlantBelief) -> tuple[Reals, Reals]:
    """Propagate mean and covariance by one sample time under the controller's force.

    The plant's own step propagates the mean; difference quotients of it are its derivatives.
    """
    scenario = knowledge.scenario
    control = force(scenario.controller, belief.controller)
    jacobian = np.zeros((4, 4))
    for i in range(4):
        more = belief.mean.copy()
        less = belief.mean.copy()
        more[i] += SMALL
        less[i] -= SMALL
        moved = advance(scenario, more, control) - advance(scenario, less, control)
        jacobian[:, i] = moved / (2.0 * SMALL)
    pushed = advance(scenario, belief.mean, control + SMALL)
    pulled = advance(scenario, belief.mean, control - SMALL)
    noise = (pushed - pulled) / (2.0 * SMALL) * knowledge.force_noise
    covariance = product(product(jacobian, belief.covariance), jacobian.T)
    covariance += noise.reshape(-1, 1) * noise
    return advance(scenario, belief.mean, control), 0.5 * (covariance + covariance.T)


def advance(scenario: Scenario, mean: Reals, control: float) -> Reals:
    """Advance a state of the filter by one sample time under a force in N."""
    dt = scenario.sample_time
    plant = integrate(scenario.plant, Pendulum(angle=mean[ANGLE], rate=mean[RATE]), control, dt)
    after = np.zeros(4)
    after[ANGLE] = plant.angle
    after[RATE] = plant.rate
    after[LAGGED] = follow(scenario.s2_sensor, mean[LAGGED], plant.angle, dt)
    after[BIAS] = mean[BIAS]
    return after


def correct(
    mean: Reals, covariance: Reals, observed: Reals, value: float, variance: float
) -> tuple[Reals, Reals]:
    """Correct by a scalar measurement.

    Args:
        mean: Before the measurement, shape (4,).
        covariance: Before the measurement, shape (4, 4).
        observed: How the state makes up the measurement, shape (4,).
        value: What was measured, rad.
        variance: Of its noise, rad^2.
    """
    shared = (covariance * observed).sum(axis=1)
    spread = (shared * observed).sum() + variance
    surprise = value - (mean * observed).sum()
    corrected = covariance - shared.reshape(-1, 1) * shared / spread
    return mean + shared * (surprise / spread), corrected


def row(first: int, second: int) -> Reals:
    """Return the measurement of the sum of two entries of the state, or of one named twice."""
    observed = np.zeros(4)
    observed[first] = 1.0
    observed[second] = 1.0
    return observed


def product(a: Reals, b: Reals) -> Reals:
    """Return the matrix product with its sums in a fixed order: the same bits compiled or not."""
    out = np.zeros((a.shape[0], b.shape[1]))
    for i in range(a.shape[0]):
        for j in range(b.shape[1]):
            for k in range(a.shape[1]):
                out[i, j] += a[i, k] * b[k, j]
    return out
