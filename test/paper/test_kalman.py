# SPDX-License-Identifier: Apache-2.0
"""The Kalman filter that knows the plant: its algebra, its own control, and its figures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from fuzzy_fusion_ros.batch.series import Series, run
from fuzzy_fusion_ros.paper import kalman
from fuzzy_fusion_ros.paper.kalman import BIAS, PlantBelief, plant_kalman
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.controller import force
from fuzzy_fusion_ros.simulation.pendulum import acceleration
from fuzzy_fusion_ros.simulation.scenario import Scenario

NOMINAL = Scenario()
SHORT = replace(NOMINAL, {"duration": 3.0})
SWEEP = pytest.mark.slow("the rest of the sweeps")
EXACT: dict[str, object] = {"s1_sensor.noise": 0.0, "s2_sensor.noise": 0.0}


class Score(NamedTuple):
    """IAE in rad s, ITAE in rad s^2, RMS error of the estimate in rad."""

    iae: float
    itae: float
    rms: float


def mean_score(changes: dict[str, object]) -> Score:
    """Return the filter's mean over some seeds, at a scenario that it is not told of."""
    scores = []
    for seed in range(20):
        scenario = replace(NOMINAL, changes)
        done = simulate(plant_kalman(NOMINAL), scenario, np.random.default_rng(seed))
        angle = np.abs(done.truth) * NOMINAL.sample_time
        t = np.arange(angle.size) * NOMINAL.sample_time
        error = done.trace.value - done.truth
        scores.append((np.sum(angle), np.sum(t * angle), np.sqrt(np.mean(error**2))))
    return Score(*np.mean(scores, axis=0).tolist())


def as_series(done: Run) -> Series:
    """Return what the sensors said in a run."""
    known = np.arange(1, done.s1.size + 1)
    return Series(done.stamps_ns, done.s1, done.stamps_ns, done.s2, known)


def test_nominal_figures_are_those_of_an_independent_filter() -> None:
    assert mean_score({}) == pytest.approx(Score(0.173, 2.65, 0.0034), rel=0.03)


@pytest.mark.parametrize(
    ("changes", "iae"),
    [
        ({"s2_sensor.time_constant": 0.05}, 0.266),
        ({"s1_sensor.noise": 0.15}, 0.186),
        ({"s1_sensor.bias": -0.1}, 0.175),
        pytest.param({"s2_sensor.time_constant": 0.10}, 0.211, marks=SWEEP),
        pytest.param({"s2_sensor.time_constant": 0.15}, 0.190, marks=SWEEP),
        pytest.param({"s2_sensor.time_constant": 0.25}, 0.165, marks=SWEEP),
        pytest.param({"s2_sensor.time_constant": 0.30}, 0.190, marks=SWEEP),
        pytest.param({"s1_sensor.bias": 0.0}, 0.172, marks=SWEEP),
        pytest.param({"s1_sensor.bias": 0.1}, 0.175, marks=SWEEP),
    ],
)
def test_so_are_those_over_the_sweeps(changes: dict[str, object], iae: float) -> None:
    assert mean_score(changes).iae == pytest.approx(iae, rel=0.04)


def test_it_knows_the_force_that_the_loop_applies_without_being_told() -> None:
    done = simulate(plant_kalman(SHORT), SHORT, np.random.default_rng(1))
    method = plant_kalman(SHORT)
    belief = method.state
    for k, stamp_ns in enumerate(done.stamps_ns[:50].tolist()):
        belief = method.observe_s2(method.parameters, belief, stamp_ns, done.s2[k])
        estimate, belief = method.update(method.parameters, belief, stamp_ns, done.s1[k])
        assert estimate.value == done.trace.value[k]
        assert force(SHORT.controller, belief.controller) == done.control[k]


def test_it_does_not_know_the_disturbance() -> None:
    series = as_series(simulate(plant_kalman(NOMINAL), NOMINAL, np.random.default_rng(1)))
    unpushed = replace(NOMINAL, {"disturbance.force": 0.0})
    told, not_told = run(plant_kalman(NOMINAL), series), run(plant_kalman(unpushed), series)
    assert told.value.tolist() == not_told.value.tolist()


def test_it_follows_exact_sensors_exactly_and_finds_the_bias() -> None:
    exact = replace(SHORT, EXACT)
    done = simulate(plant_kalman(NOMINAL), exact, np.random.default_rng(1))
    assert done.trace.value == pytest.approx(done.truth, abs=2e-4)
    method = plant_kalman(NOMINAL)
    belief = method.state
    for k, stamp_ns in enumerate(done.stamps_ns.tolist()):
        belief = method.observe_s2(method.parameters, belief, stamp_ns, done.s2[k])
        _, belief = method.update(method.parameters, belief, stamp_ns, done.s1[k])
    assert belief.mean[BIAS] == pytest.approx(NOMINAL.s1_sensor.bias, abs=1e-4)


def test_near_upright_its_derivatives_are_those_of_the_linear_plant() -> None:
    """Against the matrix exponential of the linearised plant, S2's lag and the constant bias."""
    dt = NOMINAL.sample_time
    lever = acceleration(NOMINAL.plant, 1e-6, 0.0, 0.0) / 1e-6
    gain = acceleration(NOMINAL.plant, 0.0, 0.0, 1.0)
    linear = expm(np.array([[0.0, 1.0, 0.0], [lever, 0.0, gain], [0.0, 0.0, 0.0]]) * dt)
    keep = np.exp(-dt / NOMINAL.s2_sensor.time_constant)
    transition = np.zeros((4, 4))
    transition[:2, :2] = linear[:2, :2]
    transition[2, :2] = (1.0 - keep) * linear[0, :2]
    transition[2, 2] = keep
    transition[3, 3] = 1.0
    push = np.array([*linear[:2, 2], (1.0 - keep) * linear[0, 2], 0.0])

    spread = np.diag([1.0, 2.0, 3.0, 4.0]) + 0.5
    method = plant_kalman(NOMINAL)
    belief = PlantBelief(1, np.zeros(4), spread, method.state.controller)
    _, covariance = kalman.predict(method.parameters, belief)
    noise = np.outer(push, push) * kalman.FORCE_NOISE**2
    assert covariance == pytest.approx(transition @ spread @ transition.T + noise, rel=1e-5)
    assert covariance.tolist() == covariance.T.tolist()


@given(
    root=st.lists(st.floats(-2.0, 2.0), min_size=16, max_size=16),
    mean=st.lists(st.floats(-2.0, 2.0), min_size=4, max_size=4),
    value=st.floats(-5.0, 5.0),
    variance=st.floats(1e-3, 5.0),
)
def test_a_correction_is_the_textbook_formula(
    root: list[float], mean: list[float], value: float, variance: float
) -> None:
    factor = np.array(root).reshape(4, 4)
    covariance = factor @ factor.T
    h = kalman.row(kalman.ANGLE, kalman.BIAS)
    gain = covariance @ h / (h @ covariance @ h + variance)
    expected = np.array(mean) + gain * (value - h @ np.array(mean))
    corrected, spread = kalman.correct(np.array(mean), covariance, h, value, variance)
    assert corrected == pytest.approx(expected, rel=1e-9, abs=1e-9)
    assert spread == pytest.approx((np.eye(4) - np.outer(gain, h)) @ covariance, abs=1e-8)


def test_rows_name_one_entry_or_two() -> None:
    assert kalman.row(kalman.LAGGED, kalman.LAGGED).tolist() == [0.0, 0.0, 1.0, 0.0]
    assert kalman.row(kalman.ANGLE, kalman.BIAS).tolist() == [1.0, 0.0, 0.0, 1.0]


@given(st.lists(st.floats(-9.0, 9.0), min_size=8, max_size=8))
def test_products_are_matrix_products(entries: list[float]) -> None:
    a, b = np.array(entries[:4]).reshape(2, 2), np.array(entries[4:]).reshape(2, 2)
    assert kalman.product(a, b) == pytest.approx(a @ b, abs=1e-12)
