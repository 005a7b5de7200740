# SPDX-License-Identifier: Apache-2.0
"""What fits of the candidates cost, and which values they cannot reach."""

from __future__ import annotations

import pytest
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.tuning import characterise
from fuzzy_fusion_ros.tuning.candidates import FEWEST, LONG, candidates_for
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.fit import Evaluations
from fuzzy_fusion_ros.tuning.search import MEMBERS


@pytest.fixture(scope="module")
def sensors() -> Characteristics:
    """Return the characteristics of some sensors."""
    return characterise(made(Sensors()).series)


def full_evaluations(sensors: Characteristics, samples: float) -> Evaluations:
    """Return the evaluations of the largest candidate for a recording of so many samples."""
    long = sensors._replace(span=samples * sensors.s1_interval)
    candidates = candidates_for(long, with_truth=False)
    return {each.name: each for each in candidates}["full"].spec.evaluations


def test_a_long_recording_is_run_less_often(sensors: Characteristics) -> None:
    whole = full_evaluations(sensors, LONG)
    assert full_evaluations(sensors, 100) == whole
    assert full_evaluations(sensors, 2 * LONG) == (
        whole.start // 2,
        whole.finalist // 2,
        whole.part // 2,
        1,
    )
    assert full_evaluations(sensors, 1e9) == (62, whole.finalist * FEWEST, whole.part * FEWEST, 1)


def test_to_a_truth_a_short_evolution_precedes_least_squares(sensors: Characteristics) -> None:
    for samples in (100, 1e9):
        long = sensors._replace(span=samples * sensors.s1_interval)
        for each in candidates_for(long)[2:]:
            evaluations = each.spec.evaluations
            assert evaluations.start >= 2 * MEMBERS
            assert evaluations[1:] == (1, 1, 2)


def test_without_a_truth_a_lag_that_is_not_sure_is_kept(sensors: Characteristics) -> None:
    for correlation, moved in ((0.95, True), (0.7, False)):
        unsure = sensors._replace(lag=sensors.lag._replace(correlation=correlation))
        one_way = candidates_for(unsure._replace(one_way=0.9), with_truth=False)
        (spec,) = (each.spec for each in one_way if each.name == "full")
        assert spec.space.values(spec.space.point({}))["s2.lag_time_constant"] < 0.02
        named = {each.name: each.spec for each in candidates_for(unsure, with_truth=False)}
        space = named["full"].space
        assert ("s2.lag_time_constant" in {each.name for each in space.axes}) == moved
        assert space.values(space.point({}))["s2.delay"] == pytest.approx(
            max(sensors.lag.delay, 0.05 * sensors.lag.total)
        )
        assert "s2.noise" in {each.name for each in space.axes}
