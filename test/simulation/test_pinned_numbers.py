# SPDX-License-Identifier: Apache-2.0
"""The benchmark's results, as an independent simulation gave them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.series import fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

SEEDS = range(20)
DT = 0.01
NAMES = ("very_small", "small", "large", "very_large")


class Score(NamedTuple):
    """IAE in rad s, ITAE in rad s^2, RMS error of the estimate in rad."""

    iae: float
    itae: float
    rms: float


def aggregator(weights: tuple[float, float, float, float], drift: float) -> Parameters:
    """Return the fusion with the pinned break points, these weights, and no predictor."""
    changes: dict[str, object] = {
        f"aggregator.weight.{name}": weight for name, weight in zip(NAMES, weights, strict=True)
    }
    changes |= {"aggregator.drift.small": 0.0, "aggregator.drift.large": drift}
    changes |= {"aggregator.difference.small": 0.0, "aggregator.difference.large": 0.3}
    changes |= {"aggregator.rate.small": 0.0, "aggregator.rate.large": 1.0}
    changes |= {"aggregator.rate_time_constant": 0.03, "predictor.enabled": False}
    return replace(Parameters(), changes)


S1_ALONE = aggregator((1.0, 1.0, 1.0, 1.0), drift=0.0)
S2_ALONE = aggregator((0.0, 0.0, 0.0, 0.0), drift=0.0)
AVERAGE = aggregator((0.5, 0.5, 0.5, 0.5), drift=0.0)
NO_DRIFT = aggregator((0.0, 0.05, 0.3, 0.7), drift=0.0)
FA = aggregator((0.0, 0.05, 0.3, 0.7), drift=0.1)
PERFECT_S1: dict[str, object] = {"s1_sensor.noise": 0.0, "s1_sensor.bias": 0.0}


def runs(parameters: Parameters, changes: dict[str, object]) -> list[Run]:
    """Return the run of every seed."""
    scenario = replace(Scenario(), changes)
    method = fusion(parameters)
    return [simulate(method, scenario, np.random.default_rng(seed)) for seed in SEEDS]


def score(run: Run) -> Score:
    """Return what a run came to."""
    angle = np.abs(run.truth)
    error = run.trace.value[: run.survived] - run.truth[: run.survived]
    return Score(
        iae=float(np.sum(angle) * DT),
        itae=float(np.sum(angle * np.arange(angle.size)) * DT * DT),
        rms=float(np.sqrt(np.mean(error**2))),
    )


def mean_score(parameters: Parameters, changes: dict[str, object]) -> Score:
    """Return the mean over all seeds."""
    return Score(*np.mean([score(run) for run in runs(parameters, changes)], axis=0).tolist())


@pytest.mark.parametrize(
    ("parameters", "changes", "expected"),
    [
        pytest.param(S1_ALONE, PERFECT_S1, Score(0.0855, 0.454, 0.0), id="ideal sensor"),
        pytest.param(S1_ALONE, {}, Score(2.14, 52.1, 0.0583), id="S1 alone"),
        pytest.param(AVERAGE, {}, Score(1.109, 26.7, 0.0296), id="average"),
        pytest.param(NO_DRIFT, {}, Score(0.390, 8.4, 0.0103), id="FA without drift"),
        pytest.param(FA, {}, Score(0.193, 3.72, 0.0077), id="FA"),
    ],
)
def test_the_nominal_point(
    parameters: Parameters, changes: dict[str, object], expected: Score
) -> None:
    assert mean_score(parameters, changes) == pytest.approx(expected, rel=0.05, abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "iae"),
    [
        ({"s2_sensor.time_constant": 0.05}, 0.217),
        ({"s2_sensor.time_constant": 0.10}, 0.208),
        ({"s2_sensor.time_constant": 0.15}, 0.200),
        ({"s2_sensor.time_constant": 0.25}, 0.197),
        ({"s2_sensor.time_constant": 0.30}, 0.222),
        ({"s1_sensor.noise": 0.15}, 0.261),
        ({"s1_sensor.bias": 0.0}, 0.153),
        ({"s1_sensor.bias": 0.1}, 0.39),
        ({"s1_sensor.bias": -0.1}, 0.39),
    ],
)
def test_the_aggregator_over_the_sweeps(changes: dict[str, object], iae: float) -> None:
    assert mean_score(FA, changes).iae == pytest.approx(iae, rel=0.08)


def test_s2_alone_oscillates_and_goes_on_oscillating() -> None:
    for run in runs(S2_ALONE, {}):
        assert run.survived == 5000
        end = run.truth[-1000:]
        assert end.max() > 0.2
        assert end.min() < -0.2
    assert mean_score(S2_ALONE, {}) == pytest.approx(Score(17.4, 494.0, 0.314), rel=0.05)


@pytest.mark.parametrize("time_constant", [0.25, 0.30])
def test_s2_alone_falls_when_it_is_slow(time_constant: float) -> None:
    for run in runs(S2_ALONE, {"s2_sensor.time_constant": time_constant}):
        assert run.survived < 5000


def test_s2_alone_is_good_when_it_is_fast() -> None:
    fast = mean_score(S2_ALONE, {"s2_sensor.time_constant": 0.05})
    assert fast.iae == pytest.approx(0.11, abs=0.005)
