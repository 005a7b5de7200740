# SPDX-License-Identifier: Apache-2.0
"""The closed loop: against the reference, stepped, compiled, seeded, and when it falls."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from reference import aggregator, benchmark

from fuzzy_fusion_ros.batch.compiled import interpreted
from fuzzy_fusion_ros.batch.series import Series, fusion
from fuzzy_fusion_ros.batch.series import run as run_series
from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.core.estimator import observe_s2, update
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import (
    Run,
    act,
    at_start,
    disturbance_at,
    sense,
    simulate,
)
from fuzzy_fusion_ros.simulation.pendulum import FALLEN
from fuzzy_fusion_ros.simulation.scenario import START_NS, Scenario
from fuzzy_fusion_ros.simulation.sensors import draw_noise

WEIGHTS = ("very_small", "small", "large", "very_large")


def weighted(weight: float) -> Parameters:
    """Return parameters that weigh S1 by the same whatever it reads, without drift."""
    changes: dict[str, object] = {f"aggregator.weight.{name}": weight for name in WEIGHTS}
    return replace(Parameters(), {**changes, "aggregator.drift.large": 0.0})


PINNED = replace(
    Parameters(),
    {
        "aggregator.difference.small": 0.0,
        "aggregator.difference.large": 0.3,
        "aggregator.rate.small": 0.0,
        "aggregator.rate.large": 1.0,
        "aggregator.rate_time_constant": 0.03,
        "aggregator.weight.very_small": 0.0,
        "aggregator.weight.small": 0.05,
        "aggregator.weight.large": 0.3,
        "aggregator.weight.very_large": 0.7,
        "aggregator.drift.small": 0.0,
        "aggregator.drift.large": 0.1,
    },
)
PREDICTING = replace(PINNED, {"predictor.enabled": True})
SHORT = replace(Scenario(), {"duration": 2.0})


class ReferenceFusion:
    """FA as a function of S1 and S2, sample after sample."""

    def __init__(self) -> None:
        self.last: float | None = None
        self.rate = 0.0

    def __call__(self, s1: float, s2: float) -> float:
        """Return the estimate."""
        if self.last is not None:
            self.rate = (0.03 * self.rate + s2 - self.last) / (0.03 + benchmark.SAMPLE_TIME)
        self.last = s2
        return float(aggregator.aggregate(aggregator.PINNED, s1, s2, self.rate).value)


def bits(run: Run) -> list[bytes]:
    """Return a run in a form that can be compared bit for bit."""
    arrays = [run.stamps_ns, run.truth, run.s1, run.s2, run.control, *run.trace]
    return [*(array.tobytes() for array in arrays), str(run.survived).encode()]


def simulated(parameters: Parameters, seed: int, scenario: Scenario = SHORT, **options: Any) -> Run:
    """Run a short benchmark."""
    return simulate(fusion(parameters), scenario, np.random.default_rng(seed), **options)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_whole_run_is_that_of_the_reference(seed: int) -> None:
    noise = np.random.default_rng(seed).standard_normal((5000, 2)).tolist()
    expected = benchmark.run(ReferenceFusion(), noise)
    run = simulated(PINNED, seed, Scenario())
    assert run.survived == 5000
    assert run.truth == pytest.approx(expected.angle, abs=1e-9)
    assert run.s1 == pytest.approx(expected.s1, abs=1e-9)
    assert run.s2 == pytest.approx(expected.s2, abs=1e-9)
    assert run.trace.value == pytest.approx(expected.estimate, abs=1e-9)
    assert run.control == pytest.approx(expected.force, abs=1e-6)


def test_a_fall_is_that_of_the_reference() -> None:
    slow = replace(Scenario(), {"s2_sensor.time_constant": 0.3})
    noise = np.random.default_rng(3).standard_normal((5000, 2)).tolist()
    expected = benchmark.run(lambda s1, s2: s2, noise, s2_lag=0.3)
    run = simulated(weighted(0.0), 3, slow)
    assert run.survived == len(expected.s2) < 5000
    assert run.truth[run.survived :].tolist() == [FALLEN] * (5000 - run.survived)
    assert run.truth[: run.survived] == pytest.approx(expected.angle[: run.survived], abs=1e-6)
    assert np.abs(run.truth[: run.survived]).max() < FALLEN


def test_stamps_are_those_of_the_samples() -> None:
    run = simulated(PINNED, 0)
    assert run.stamps_ns.tolist() == [START_NS + k * 10_000_000 for k in range(200)]


@pytest.mark.parametrize("parameters", [PINNED, PREDICTING])
def test_one_seed_gives_one_run_bit_for_bit(parameters: Parameters) -> None:
    assert bits(simulated(parameters, 7)) == bits(simulated(parameters, 7))


def test_another_seed_gives_another_run() -> None:
    one, other = simulated(PINNED, 7), simulated(PINNED, 8)
    assert one.s1[0] != other.s1[0]
    assert one.truth[0] == other.truth[0] == 0.2
    assert one.truth[-1] != other.truth[-1]


def test_a_run_draws_from_its_generator_and_no_more_than_it_needs() -> None:
    generator, rest = np.random.default_rng(7), np.random.default_rng(7)
    simulate(fusion(PINNED), SHORT, generator)
    draw_noise(rest, 200)
    assert generator.standard_normal() == rest.standard_normal()


@pytest.mark.parametrize("parameters", [PINNED, PREDICTING])
def test_stepping_as_a_node_does_is_the_run_bit_for_bit(parameters: Parameters) -> None:
    """Invariant 1's inner part: sense, estimate, act; noise drawn as it goes."""
    run = simulated(parameters, 5)
    generator = np.random.default_rng(5)
    loop = at_start(SHORT)
    method = fusion(parameters)
    state = method.state
    for k in range(200):
        noise = draw_noise(generator, 1)[0]
        reading = sense(SHORT, loop, noise[0], noise[1])
        assert (loop.k, loop.plant.angle) == (k, run.truth[k])
        assert reading == (run.s1[k], run.s2[k])
        stamp_ns = int(run.stamps_ns[k])
        state = observe_s2(parameters, state, stamp_ns, reading.s2)
        estimate, state = update(parameters, state, stamp_ns, reading.s1)
        control, loop = act(SHORT, loop, estimate.value)
        assert (estimate.value, control) == (run.trace.value[k], run.control[k])


@pytest.mark.parametrize("parameters", [PINNED, PREDICTING])
def test_compiled_is_interpreted_bit_for_bit(parameters: Parameters) -> None:
    assert bits(simulated(parameters, 6, bind=interpreted)) == bits(simulated(parameters, 6))


def test_an_interpreted_fall_ends_the_run() -> None:
    toppled = replace(SHORT, {"plant.initial_angle": 1.5, "controller.limit": 0.0})
    run = simulated(PINNED, 0, toppled)
    assert run.survived < 200
    assert bits(simulated(PINNED, 0, toppled, bind=interpreted)) == bits(run)


def test_a_replay_of_what_the_sensors_read_gives_the_estimates_of_the_run() -> None:
    run = simulated(PREDICTING, 4)
    known = np.arange(1, 201)
    trace = run_series(
        fusion(PREDICTING), Series(run.stamps_ns, run.s1, run.stamps_ns, run.s2, known)
    )
    assert [a.tobytes() for a in trace] == [a.tobytes() for a in run.trace]


def test_at_the_start_s2_reads_the_true_angle() -> None:
    tilted = replace(Scenario(), {"plant.initial_angle": -0.4, "plant.initial_rate": 0.5})
    loop = at_start(tilted)
    assert loop.plant == (-0.4, 0.5)
    assert not loop.fallen
    assert sense(tilted, loop, 0.0, 0.0) == (pytest.approx(-0.43), -0.4)


@pytest.mark.parametrize(
    ("sample_time", "k", "force"),
    [
        (0.01, 2499, 0.0),
        (0.01, 2500, -5.0),
        (0.01, 2509, -5.0),
        (0.01, 2510, 0.0),
        (0.1, 250, -5.0),
        (0.1, 251, 0.0),
        (1e-3, 25099, -5.0),
        (1e-3, 25100, 0.0),
    ],
)
def test_the_push_is_half_open_whatever_the_rounding(
    sample_time: float, k: int, force: float
) -> None:
    assert disturbance_at(replace(Scenario(), {"sample_time": sample_time}), k) == force


@pytest.mark.parametrize("angle", [1.5, -1.5])
def test_it_has_fallen_at_a_right_angle_on_either_side(angle: float) -> None:
    still = replace(Scenario(), {"plant.initial_angle": angle, "controller.limit": 0.0})
    loop = at_start(still)
    while not loop.fallen:
        before = loop
        _, loop = act(still, loop, 0.0)
    assert abs(before.plant.angle) < FALLEN <= abs(loop.plant.angle)
    assert math.copysign(1.0, loop.plant.angle) == math.copysign(1.0, angle)


def test_constant_weights_stand_for_the_sensors_alone() -> None:
    """What the pinned numbers of the sensors alone are measured with."""
    for weight in (0.0, 0.5, 1.0):
        said = aggregate(weighted(weight).aggregator, 0.3, -0.1, 0.7)
        assert said.value == pytest.approx(weight * 0.3 - (1.0 - weight) * 0.1)
