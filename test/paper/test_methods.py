# SPDX-License-Identifier: Apache-2.0
"""The methods of the benchmark do what their names say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters
from fuzzy_fusion_ros.jobs.parameter_file import fusion_parameters
from fuzzy_fusion_ros.paper import methods
from fuzzy_fusion_ros.paper.methods import METHODS, Contender, contenders, warm_up
from fuzzy_fusion_ros.paper.sweep import NOMINAL, outcome_of, simulate_at
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

BRIEF = replace(Scenario(), {"duration": 1.0})
BY_NAME = {each.name: each for each in contenders(Parameters())}


def brief_run(name: str) -> Run:
    """Return a second of a method's run."""
    contender = BY_NAME[name]
    scenario = contender.with_its_sensors(BRIEF)
    return simulate(contender.method, scenario, np.random.default_rng(3))


def test_they_are_those_of_the_document_in_its_order() -> None:
    assert tuple(BY_NAME) == METHODS
    first = ("ideal", "s1", "s2", "average", "no_drift", "aggregator", "complete")
    assert (*first, "complementary", "kalman") == METHODS


@pytest.mark.parametrize("name", METHODS)
def test_only_the_ideal_one_reads_an_s1_without_errors(name: str) -> None:
    sensor = BY_NAME[name].with_its_sensors(BRIEF).s1_sensor
    assert ((sensor.noise, sensor.bias) == (0.0, 0.0)) == (name == "ideal")
    if name != "ideal":
        assert BY_NAME[name].with_its_sensors(BRIEF) == BRIEF


def test_constant_weights_are_exact() -> None:
    assert brief_run("ideal").trace.value.tolist() == brief_run("ideal").truth.tolist()
    s1, s2, average = brief_run("s1"), brief_run("s2"), brief_run("average")
    assert s1.trace.value.tolist() == s1.s1.tolist()
    assert s2.trace.value.tolist() == s2.s2.tolist()
    assert average.trace.value == pytest.approx(0.5 * (average.s1 + average.s2), abs=1e-15)


@pytest.mark.parametrize("name", METHODS)
def test_stepped_one_by_one_they_say_what_the_compiled_loop_says(name: str) -> None:
    method, run = BY_NAME[name].method, brief_run(name)
    state = method.state
    for k, stamp_ns in enumerate(run.stamps_ns.tolist()):
        state = method.observe_s2(method.parameters, state, stamp_ns, run.s2[k])
        estimate, state = method.update(method.parameters, state, stamp_ns, run.s1[k])
        assert estimate.value == run.trace.value[k]


def test_drift_and_predictor_are_on_where_the_names_say() -> None:
    assert not brief_run("no_drift").trace.drift.any()
    for name in ("aggregator", "complete"):
        assert brief_run(name).trace.drift.any()
    for name in ("no_drift", "aggregator"):
        assert not brief_run(name).trace.predicted.any()
    assert brief_run("complete").trace.predicted.any()


def test_parameters_of_the_fusion_reach_the_fusion_only() -> None:
    other = replace(Parameters(), {"aggregator.rate_time_constant": 0.5})
    for each in contenders(other):
        same = each.method.parameters == BY_NAME[each.name].method.parameters
        assert same == (each.name not in {"no_drift", "aggregator", "complete"})


def test_a_complementary_filter_that_knows_the_lag_is_exact_with_exact_sensors() -> None:
    changes = {"s1_sensor.noise": 0.0, "s1_sensor.bias": 0.0, "s2_sensor.noise": 0.0}
    exact = replace(BRIEF, changes)
    lag = exact.s2_sensor.time_constant
    changes = {"complementary.time_constant": lag, "complementary.s2_lags": True}
    method = BASELINES["complementary"].method(replace(BaselineParameters(), changes))
    run = simulate(method, exact, np.random.default_rng(1))
    assert run.trace.value == pytest.approx(run.truth, abs=1e-12)


def test_the_complementary_filter_does_not_see_a_constant_bias() -> None:
    method = BY_NAME["complementary"].method
    biased = replace(BRIEF, {"s1_sensor.bias": 0.7})
    runs = [simulate(method, each, np.random.default_rng(1)) for each in (BRIEF, biased)]
    assert runs[0].truth == pytest.approx(runs[1].truth, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "iae", "itae", "rms"),
    [
        ("s1", 2.14, 52.1, 0.0583),
        ("average", 1.109, 26.7, 0.0296),
        ("complementary", 0.645, 14.7, 0.0484),
    ],
)
def test_figures_are_those_of_an_independent_simulation(
    name: str, iae: float, itae: float, rms: float
) -> None:
    figures = []
    for seed in range(20):
        run = simulate(BY_NAME[name].method, Scenario(), np.random.default_rng(seed))
        angle = np.abs(run.truth) * 0.01
        error = run.trace.value - run.truth
        t = np.arange(angle.size) * 0.01
        figures.append((np.sum(angle), np.sum(t * angle), np.sqrt(np.mean(error**2))))
    assert np.mean(figures, axis=0) == pytest.approx([iae, itae, rms], rel=0.03)


def test_warming_up_runs_a_single_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    lengths = []

    def spy(method: object, scenario: Scenario, generator: np.random.Generator) -> None:
        lengths.append(scenario.duration / scenario.sample_time)

    monkeypatch.setattr(methods, "simulate", spy)
    warm_up(Contender("s1", BY_NAME["s1"].method, ideal=False))
    assert lengths == [1.0]


def test_the_observer_balances_better_than_the_blend_whatever_s1_is_off_by() -> None:
    path = Path(__file__).parents[2] / "config" / "pendulum_observer.yaml"
    observer = {each.name: each for each in contenders(fusion_parameters(path))}["complete"]
    iae = []
    for point in (NOMINAL, NOMINAL._replace(bias1=0.1)):
        found, blend = (
            outcome_of("complete", point, 1000, simulate_at(each, point, 1000)).iae
            for each in (observer, BY_NAME["complete"])
        )
        assert found < blend
        iae.append(found)
    assert iae[1] == pytest.approx(iae[0], rel=0.02)
