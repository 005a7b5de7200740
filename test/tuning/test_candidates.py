"""What fits of the candidates cost, and which values they cannot reach."""

from __future__ import annotations

import numpy as np
import pytest
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.tuning import characterise
from fuzzy_fusion_ros.tuning.candidates import FEWEST, LONG, candidates_for
from fuzzy_fusion_ros.tuning.characterise import Characteristics
from fuzzy_fusion_ros.tuning.fit import Evaluations
from fuzzy_fusion_ros.tuning.space import SLOPE_OVER_BIAS


@pytest.fixture(scope="module")
def sensors() -> Characteristics:
    """Return the characteristics of some sensors."""
    return characterise(made(Sensors()).series)


def full_evaluations(sensors: Characteristics, samples: float) -> Evaluations:
    """Return the evaluations of the largest candidate for a recording of so many samples."""
    long = sensors._replace(span=samples * sensors.s1_interval)
    return {each.name: each for each in candidates_for(long)}["full"].spec.evaluations


def test_a_long_recording_is_run_less_often(sensors: Characteristics) -> None:
    whole = full_evaluations(sensors, LONG)
    assert full_evaluations(sensors, 100) == whole
    assert full_evaluations(sensors, 2 * LONG) == tuple(round(each / 2) for each in whole)
    assert full_evaluations(sensors, 1e9) == tuple(round(FEWEST * each) for each in whole)


def test_a_slope_is_never_learnt_much_quicker_than_its_bias(sensors: Characteristics) -> None:
    space = {each.name: each for each in candidates_for(sensors)}["full"].spec.space
    generator = np.random.default_rng(0)
    for point in generator.random((50, len(space.axes))):
        values = space.values(point)
        least = SLOPE_OVER_BIAS * values["s1.bias_time_constant"]
        assert values["s1.drift_time_constant"] >= least * (1.0 - 1e-9)
