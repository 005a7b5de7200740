# SPDX-License-Identifier: Apache-2.0
"""Arrays in, arrays out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import ArrayLike

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.jobs.fuse import fuse
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

TIME_S = np.arange(100) * 0.01
SIGNAL = np.sin(3.0 * TIME_S)


@pytest.mark.parametrize("origin", [0.0, -5.0, 1.7e9])
def test_it_is_what_a_node_makes_of_the_samples(origin: float) -> None:
    fusion = Fusion(Parameters())
    expected = []
    for k in range(100):
        stamp_ns = 10**9 + k * 10**7
        if k % 10 == 0:
            fusion.on_s2(Sample(stamp_ns, SIGNAL[k] - 0.1))
        expected += fusion.on_s1(Sample(stamp_ns, SIGNAL[k])).estimates
    found = fuse(origin + TIME_S, SIGNAL, origin + TIME_S[::10], SIGNAL[::10] - 0.1)
    assert found.value == pytest.approx([each.estimate.value for each in expected], abs=1e-5)
    assert found.time_s.tolist() == (origin + TIME_S).tolist()
    assert found.weight.shape == found.drift.shape == found.value.shape
    assert set(found.mode) == {"FUSED"}
    if origin == 0.0:
        assert found.value.tolist() == [each.estimate.value for each in expected]


def test_what_is_not_finite_is_dropped() -> None:
    holed = np.where(np.arange(100) % 7 == 3, math.nan, SIGNAL)
    found = fuse(TIME_S, holed, TIME_S, SIGNAL)
    assert found.time_s.tolist() == TIME_S[np.isfinite(holed)].tolist()
    assert np.isfinite(found.value).all()


def test_modes_are_named() -> None:
    parameters = replace(Parameters(), {"s2.timeout": 0.2, "s1.timeout": 0.2})
    found = fuse(
        TIME_S[:60], SIGNAL[:60], TIME_S[[0, 10, 95]], SIGNAL[[0, 10, 95]], parameters=parameters
    )
    assert list(dict.fromkeys(found.mode)) == ["FUSED", "S1_ONLY", "S2_ONLY"]


def test_a_timer_makes_estimates_at_its_rate() -> None:
    parameters = replace(Parameters(), {"trigger": "timer", "rate": 20.0})
    found = fuse(TIME_S, SIGNAL, TIME_S, SIGNAL, parameters=parameters)
    assert np.diff(found.time_s) == pytest.approx(0.05)


def test_without_samples_there_are_no_estimates() -> None:
    assert [each.size for each in fuse([], [], [], [])] == [0] * 5
    assert fuse([], [], TIME_S[:1], SIGNAL[:1]).value.size == 0


@pytest.mark.parametrize(
    ("time_s", "values", "problem"),
    [
        ([0.0, 1.0], [1.0], r"S1: got times of shape \(2,\) and samples of shape \(1,\)"),
        ([[0.0]], [[1.0]], r"S1: got times of shape \(1, 1\)"),
        ([1.0, 1.0], [1.0, 1.0], "S1: got times that are not finite or not increasing"),
        ([math.nan], [1.0], "S1: got times that are not finite"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(
    time_s: ArrayLike, values: ArrayLike, problem: str
) -> None:
    with pytest.raises(FusionError, match=problem):
        fuse(time_s, values, [0.0], [1.0])
