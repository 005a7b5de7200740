# SPDX-License-Identifier: Apache-2.0
"""How sure the estimate is said to be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.deviation import MEMORY, SHOCK, Evidence, no_evidence, weighed
from fuzzy_fusion_ros.core.estimator import (
    Estimate,
    State,
    initial_state,
    observe_s2,
    update,
    without_s1,
)
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000
STEP = 10_000_000
PLAIN = Parameters()
LEARNING = replace(
    PLAIN,
    {
        "s1.bias_time_constant": 2.0,
        "s1.bias_prior": 1.0,
        "s2.noise": 0.1,
        "s2.lag_time_constant": 0.2,
        "aggregator.difference.small": 1e8,
        "aggregator.difference.large": 1e9,
        "aggregator.rate.large": 1e9,
        "aggregator.weight.small": 0.0,
    },
)


def fed(
    parameters: Parameters,
    s1: list[float],
    s2: list[float],
    state: State | None = None,
    at: int = 1,
) -> tuple[list[Estimate], State]:
    """Feed samples at 100 Hz; S2 ends where there are fewer."""
    state = state or initial_state(parameters)
    said = []
    for k, value in enumerate(s1):
        stamp_ns = at * SECOND + k * STEP
        if k < len(s2):
            state = observe_s2(parameters, state, stamp_ns, s2[k])
        estimate, state = update(parameters, state, stamp_ns, value)
        said.append(estimate)
    return said, state


def noisy(size: float, samples: int = 2000) -> list[float]:
    """Return white noise."""
    return np.random.default_rng(0).normal(0.0, size, samples).tolist()


@pytest.mark.parametrize("parameters", [PLAIN, LEARNING])
def test_it_grows_while_s2_is_silent(parameters: Parameters) -> None:
    said, _ = fed(parameters, noisy(0.1, 3000), noisy(0.1, 1000))
    sure = [each.standard_deviation for each in said[999::200]]
    assert sure == sorted(sure)
    assert sure[-1] > 1.2 * sure[0]


@pytest.mark.parametrize("parameters", [PLAIN, LEARNING])
def test_it_follows_what_s2_says_now(parameters: Parameters) -> None:
    still = [0.0] * 500
    calm, state = fed(parameters, still, noisy(0.1, 500))
    busy, _ = fed(parameters, still, noisy(0.5, 500), state, at=6)
    assert busy[-1].standard_deviation > 2.0 * calm[-1].standard_deviation


def test_it_is_right_where_the_model_is() -> None:
    """S1 exact but for a walking bias, S2 noisy: the Kalman filter's own standard deviation."""
    walk = np.cumsum(noisy(0.005, 20_000)).tolist()  # 0.1 a step / T / 0.01 s: q = 0.05 / sqrt(s)
    parameters = replace(LEARNING, {"s2.lag_time_constant": 0.0, "s1.bias_time_constant": 0.2})
    measured = np.random.default_rng(1).normal(0.0, 0.1, 20_000).tolist()
    said, _ = fed(parameters, walk, measured)
    error = np.array([each.value for each in said])[1000:]
    sure = np.array([each.standard_deviation for each in said])[1000:]
    assert np.mean(np.abs(error) <= sure) == pytest.approx(0.683, abs=0.05)
    assert np.mean(np.abs(error) <= 2.0 * sure) == pytest.approx(0.954, abs=0.03)


def test_scale_and_floor_are_what_tune_fits() -> None:
    twice = replace(LEARNING, {"estimate.deviation_scale": 2.0})
    one, two = (fed(each, noisy(0.1), noisy(0.1))[0][-1] for each in (LEARNING, twice))
    assert two.standard_deviation == pytest.approx(2.0 * one.standard_deviation)
    floor = replace(LEARNING, {"s1.noise": 0.3})
    noisier = fed(floor, noisy(0.1), noisy(0.1))[0][-1].standard_deviation
    assert noisier == pytest.approx(math.hypot(one.standard_deviation, 0.3))


@pytest.mark.parametrize("parameters", [PLAIN, LEARNING])
def test_without_s2_nothing_is_known_and_s2_alone_counts_as_late(parameters: Parameters) -> None:
    said, _ = fed(parameters, [0.0] * 600, [])
    assert {each.standard_deviation for each in said} == {0.0}
    _, state = fed(parameters, [0.0] * 500, noisy(0.1, 500))
    still = without_s1(parameters, state, 6 * SECOND).standard_deviation
    for k in range(5):
        state = observe_s2(parameters, state, 60 * SECOND + k * STEP, 0.5 * k)
    moving = without_s1(parameters, state, 61 * SECOND).standard_deviation
    assert moving >= still > 0.0
    assert (moving > 2.0 * still) == (parameters is LEARNING)  # only there S2's lag is known


def test_an_outlier_is_no_noise_but_many_are() -> None:
    kept = Evidence(MEMORY, 0.01)
    once = weighed(kept, 0.1, 1e6, 1.0)
    assert once.variance == pytest.approx(0.01 * (1.0 + (SHOCK - 1.0) / MEMORY))
    for _ in range(MEMORY):
        kept = weighed(kept, 0.1, 10.0, 1.0)
    assert kept.variance > 10.0


def test_the_first_innovations_are_weighed_against_the_noise_that_is_known() -> None:
    assert weighed(no_evidence(), 0.1, 0.1, 1.0).variance == pytest.approx(0.01)
    assert weighed(no_evidence(), 0.0, 0.3, 1.0) == (1, pytest.approx(0.09))


@given(st.lists(st.tuples(st.floats(-1.7e308, 1.7e308), st.floats(-1.7e308, 1.7e308)), max_size=20))
def test_it_is_finite_and_not_negative(samples: list[tuple[float, float]]) -> None:
    for parameters in (PLAIN, LEARNING):
        said, state = fed(parameters, [a for a, _ in samples], [b for _, b in samples])
        alone = without_s1(parameters, state, SECOND)
        for each in (*said, alone):
            assert 0.0 <= each.standard_deviation < float("inf")
