# SPDX-License-Identifier: Apache-2.0
"""The sweeps: their points, their seeds, and what a run comes to."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference.benchmark import integral_of_error, integral_of_timed_error

from fuzzy_fusion_ros.batch.series import empty_trace
from fuzzy_fusion_ros.paper.methods import contenders
from fuzzy_fusion_ros.paper.sweep import (
    NOMINAL,
    SWEEPS,
    Point,
    elapsed,
    outcome_of,
    points_of,
    scenario_at,
    simulate_at,
    sweep,
    sweep_points,
)
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.simulation.closed_loop import Run
from fuzzy_fusion_ros.simulation.scenario import Scenario

BY_NAME = {each.name: each for each in contenders(Parameters())}
QUICK = (BY_NAME["s2"], BY_NAME["average"])


def made_up_run(truth: list[float], survived: int | None = None) -> Run:
    """Return a run of the full length that took this course at its end, 0 before."""
    n = 5000
    angle = np.zeros(n)
    angle[n - len(truth) :] = truth
    return Run(
        stamps_ns=np.arange(n, dtype=np.int64) * 10_000_000 + 1_000_000_000,
        truth=angle,
        s1=angle - 0.5,
        s2=angle + 0.25,
        control=np.zeros(n),
        trace=empty_trace(n)._replace(value=angle + 2.0),
        survived=n if survived is None else survived,
    )


def test_the_points_are_those_that_are_pinned() -> None:
    assert Point(tau2=0.2, sigma1=0.05, bias1=-0.03) == NOMINAL
    assert SWEEPS["tau2"] == (0.05, 0.10, 0.15, 0.20, 0.25, 0.30)
    assert SWEEPS["sigma1"] == (0.02, 0.05, 0.10, 0.15)
    assert SWEEPS["bias1"] == (-0.10, -0.06, -0.03, 0.0, 0.03, 0.06, 0.10)


def test_all_points_are_the_nominal_one_and_those_of_each_sweep_once() -> None:
    points = points_of(SWEEPS)
    assert points[0] == NOMINAL
    assert len(points) == len(set(points)) == 6 + 4 + 7 - 2
    assert set(points) == {p for swept in SWEEPS for p in sweep_points(swept)}
    assert points_of([]) == (NOMINAL,)


@pytest.mark.parametrize("swept", SWEEPS)
def test_a_sweep_changes_one_thing(swept: str) -> None:
    for point, value in zip(sweep_points(swept), SWEEPS[swept], strict=True):
        assert point == NOMINAL._replace(**{swept: value})
    assert NOMINAL in sweep_points(swept)


def test_a_scenario_is_nominal_but_for_its_point() -> None:
    assert scenario_at(NOMINAL) == Scenario()
    scenario = scenario_at(Point(0.3, 0.15, 0.1))
    assert scenario.s2_sensor.time_constant == 0.3
    assert (scenario.s1_sensor.noise, scenario.s1_sensor.bias) == (0.15, 0.1)
    assert scenario.plant == Scenario().plant


def test_methods_meet_the_same_noise_with_the_same_seed() -> None:
    runs = [simulate_at(BY_NAME[name], NOMINAL, 7) for name in ("s1", "average", "aggregator")]
    for run in runs:
        assert run.s1 - run.truth == pytest.approx(runs[0].s1 - runs[0].truth, abs=1e-12)
    assert (simulate_at(BY_NAME["s1"], NOMINAL, 8).s1 != runs[0].s1).all()


def test_outcomes_come_in_one_order_whatever_the_number_of_threads() -> None:
    points = (NOMINAL, NOMINAL._replace(tau2=0.1))
    alone, together = (list(sweep(QUICK, points, (4, 5), jobs)) for jobs in (1, 4))
    assert repr(alone) == repr(together)  # as text, for NaN equals nothing
    assert [(o.point, o.seed, o.method) for o in alone] == [
        (point, seed, method) for point in points for seed in (4, 5) for method in ("s2", "average")
    ]


def test_a_sweep_that_is_given_up_leaves_no_thread_behind() -> None:
    runs = sweep(QUICK, [NOMINAL], range(100), 2)
    next(runs)
    runs.close()


def test_an_outcome_sums_what_the_reference_sums() -> None:
    run = simulate_at(BY_NAME["average"], NOMINAL, 11)
    outcome = outcome_of("average", NOMINAL, 11, run)
    angle = run.truth.tolist()
    assert outcome.iae == pytest.approx(integral_of_error(angle), rel=1e-12)
    assert outcome.itae == pytest.approx(integral_of_timed_error(angle), rel=1e-12)
    assert (outcome.method, outcome.point, outcome.seed) == ("average", NOMINAL, 11)
    assert not outcome.fell
    assert outcome.s1_offset == pytest.approx(-0.03, abs=0.004)


def test_errors_are_measured_against_the_angle() -> None:
    outcome = outcome_of("s1", NOMINAL, 0, made_up_run([0.0]))
    assert outcome.rmse == pytest.approx(2.0)
    assert (outcome.s1_rmse, outcome.s1_offset, outcome.s2_rmse) == (0.5, -0.5, 0.25)


def test_a_fall_counts_for_the_rest_of_the_run_but_not_for_the_error() -> None:
    slow = NOMINAL._replace(tau2=0.3)
    run = simulate_at(BY_NAME["s2"], slow, 1)
    outcome = outcome_of("s2", slow, 1, run)
    assert outcome.fell
    after = (run.truth.size - run.survived) * 0.01 * math.pi / 2
    assert outcome.iae > after
    error = run.trace.value[: run.survived] - run.truth[: run.survived]
    assert outcome.rmse == pytest.approx(math.sqrt(np.mean(error**2)))


@pytest.mark.parametrize(
    ("end", "swing"),
    [
        ([0.3, -0.2], 0.2),
        ([0.3, 0.2], 0.0),
        ([0.3] * 1000, -0.3),
        ([-0.3] * 1000, -0.3),
        ([0.5, *[0.0] * 1000], 0.0),
    ],
)
def test_a_swing_goes_to_both_sides_in_the_last_ten_seconds(end: list[float], swing: float) -> None:
    assert outcome_of("s2", NOMINAL, 0, made_up_run(end)).swing == pytest.approx(swing)


def test_a_swing_before_a_fall_counts() -> None:
    run = made_up_run([math.pi / 2] * 2000, survived=3000)
    run.truth[2000:3000] = np.linspace(-0.4, 0.6, 1000)
    assert outcome_of("s2", NOMINAL, 0, run).swing == pytest.approx(0.4)


def test_unrest_is_looked_for_between_settling_and_push() -> None:
    run = made_up_run([0.0])
    run.truth[499], run.truth[500], run.truth[2499], run.truth[2500] = 9.0, -0.25, 0.125, 9.0
    assert outcome_of("s2", NOMINAL, 0, run).unrest == 0.25


def test_rejections_are_counted_from_the_push_until_it_is_over_and_in_the_calm_before() -> None:
    run = made_up_run([0.0])
    assert math.isnan(outcome_of("complete", NOMINAL, 0, run).rejected_pushed)
    run.trace.predicted[:] = True
    run.trace.accepted[:] = True
    run.trace.accepted[2530:2600] = False
    run.trace.accepted[500:1000] = False
    outcome = outcome_of("complete", NOMINAL, 0, run)
    assert outcome.rejected_pushed == 0.4  # 2530 to 2549 of 2500 to 2549
    assert outcome.rejected_calm == 0.25


def test_times_begin_at_zero() -> None:
    assert elapsed(made_up_run([0.0]))[[0, 1, -1]] == pytest.approx([0.0, 0.01, 49.99])
