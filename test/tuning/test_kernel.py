# SPDX-License-Identifier: Apache-2.0
"""The fast run is the estimator, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters
from fuzzy_fusion_ros.batch.series import fusion, run, values
from fuzzy_fusion_ros.core.estimator import FUSED, WAITING
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.tuning.kernel import outputs

CONDITIONED = {
    "s1.lowpass_time_constant": 0.1,
    "s1.bias_time_constant": 3.0,
    "s1.drift_time_constant": 20.0,
    "s1.spike_threshold": 1.0,
    "s2.lag_time_constant": 0.3,
    "s2.delay": 0.2,
    "s2.timeout": 0.6,
}


@pytest.mark.parametrize("name", ["fusion", *BASELINES])
def test_values_are_those_of_a_whole_run(name: str) -> None:
    series = made(Sensors(gap=(10.0, 15.0), spikes=0.05), seconds=20.0).series
    if name == "fusion":
        method = fusion(replace(Parameters(), {**CONDITIONED, "predictor.enabled": True}))
    else:
        method = BASELINES[name].method(BaselineParameters())
    assert values(method, series).tolist() == run(method, series).value.tolist()


ADAPTING = {
    **CONDITIONED,
    "s2.outlier_threshold": 2.0,
    "adapt.lag_time_constant": 5.0,
    "adapt.scale_time_constant": 10.0,
}


@pytest.mark.parametrize(
    "changes", [{}, CONDITIONED, ADAPTING], ids=["plain", "conditioned", "adapting"]
)
def test_it_is_the_estimator(changes: dict[str, float]) -> None:
    series = made(Sensors(gap=(10.0, 15.0), spikes=0.05)).series
    parameters = replace(Parameters(), changes)
    trace = run(fusion(parameters), series)
    plain = run(fusion(parameters), series, compiles=False)
    assert trace.value.tolist() == plain.value.tolist()
    output = outputs(parameters, series)
    there = trace.mode != WAITING
    assert output.value[there].tolist() == trace.value[there].tolist()
    assert np.isfinite(output.difference).tolist() == (trace.mode == FUSED).tolist()
    assert np.isfinite(output.rate).tolist() == (trace.mode == FUSED).tolist()
    assert np.isfinite(output.value).all()
