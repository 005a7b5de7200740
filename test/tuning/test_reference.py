# SPDX-License-Identifier: Apache-2.0
"""Hindsight is nearer to the truth than either sensor, whatever ails them."""

from __future__ import annotations

import numpy as np
import pytest
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import held_s2
from fuzzy_fusion_ros.tuning import characterise, reference_without_truth

AILMENTS = {
    "bias": Sensors(bias=0.5),
    "drift": Sensors(drift=0.02),
    "noise": Sensors(noise=0.2),
    "spikes": Sensors(spikes=0.1),
    "delay": Sensors(delay=0.5, lag=0.1),
    "gap": Sensors(gap=(12.0, 22.0), drift=0.02),
}


@pytest.mark.parametrize("sensors", AILMENTS.values(), ids=AILMENTS)
def test_it_is_near_the_truth(sensors: Sensors) -> None:
    series, truth = made(sensors, seconds=80.0)
    known = series.s2_known > 0
    found = reference_without_truth(series, characterise(series))

    def error(values: Reals) -> float:
        return float(np.sqrt(np.mean(np.square((values - truth)[known]))))

    assert error(found) < 0.6 * min(error(series.s1), error(held_s2(series)))
