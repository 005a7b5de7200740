# SPDX-License-Identifier: Apache-2.0
"""The complementary filter, against its transfer functions and the benchmark."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.baselines import ComplementaryParameters, complementary
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

SECOND = 1_000_000_000


def filtered(
    parameters: ComplementaryParameters, times_s: list[float], s1: list[float], s2: list[float]
) -> list[float]:
    """Filter samples of both sensors at the same times."""
    method = complementary(parameters)
    state, found = method.state, []
    for time_s, fast, slow in zip(times_s, s1, s2, strict=True):
        stamp_ns = SECOND + round(time_s * SECOND)
        state = method.observe_s2(method.parameters, state, stamp_ns, slow)
        estimate, state = method.update(method.parameters, state, stamp_ns, fast)
        found.append(estimate.value)
    return found


def test_a_step_of_s1_decays_with_the_time_constant() -> None:
    times = [0.0, 0.1, 0.15, 0.4, 1.0]
    found = filtered(ComplementaryParameters(0.3), times, [0.0, 1.0, 1.0, 1.0, 1.0], [0.0] * 5)
    after = [math.exp(-(t - 0.1) / 0.3) * math.exp(-0.1 / 0.3) for t in times[1:]]
    assert found == pytest.approx([0.0, *after])


def test_a_step_of_s2_comes_in_with_the_time_constant() -> None:
    times = [0.0, 0.1, 0.15, 0.4, 1.0]
    found = filtered(ComplementaryParameters(0.3), times, [0.0] * 5, [0.0, 1.0, 1.0, 1.0, 1.0])
    assert found == pytest.approx([1.0 - math.exp(-t / 0.3) for t in times])


def test_a_bias_of_s1_does_not_matter() -> None:
    times = np.arange(300) * 0.01
    truth = np.sin(times).tolist()
    plain = filtered(ComplementaryParameters(0.5), times.tolist(), truth, truth)
    biased = [value + 3.0 for value in truth]
    found = filtered(ComplementaryParameters(0.5), times.tolist(), biased, truth)
    assert found == pytest.approx(plain, abs=1e-12)


def test_an_s2_that_lags_is_completed_to_the_truth() -> None:
    time_constant, dt = 0.2, 0.01
    truth = [0.0, *np.cumsum(np.random.default_rng(0).normal(0.0, 0.1, 500))]
    lagged = [0.0]
    for before, _ in pairwise(truth):
        lagged.append(lagged[-1] + (1.0 - math.exp(-dt / time_constant)) * (before - lagged[-1]))
    # S2 as it would be if the truth stepped right at the samples: low-pass of the last value.
    found = filtered(
        ComplementaryParameters(time_constant, s2_lags=True),
        [k * dt for k in range(len(truth))],
        truth,
        lagged,
    )
    highs, high = [0.0], 0.0
    for before, now in pairwise(truth):
        high = math.exp(-dt / time_constant) * (high + now - before)
        highs.append(high)
    assert found == pytest.approx([h + low for h, low in zip(highs, lagged, strict=True)])
    assert np.sqrt(np.mean(np.subtract(found, truth) ** 2)) < 0.2 * np.std(
        np.subtract(lagged, truth)
    )


@given(
    splits=st.lists(st.floats(0.001, 0.5), min_size=1, max_size=10),
    time_constant=st.floats(0.01, 10.0),
)
def test_samples_that_bring_nothing_new_change_nothing(
    splits: list[float], time_constant: float
) -> None:
    """The discretisation is exact: how often constant sensors are read does not matter."""
    parameters = ComplementaryParameters(time_constant)
    times = [0.0, 0.1, *(0.1 + np.cumsum(splits)).tolist()]
    fine = filtered(parameters, times, [0.0] + [1.0] * (len(times) - 1), [0.0] * len(times))
    coarse = filtered(parameters, [0.0, 0.1, times[-1]], [0.0, 1.0, 1.0], [0.0] * 3)
    assert fine[-1] == pytest.approx(coarse[-1], rel=1e-6, abs=1e-9)


def test_the_low_pass_quietens_s1() -> None:
    noise = np.random.default_rng(1).normal(0.0, 1.0, 2000)
    times = (np.arange(2000) * 0.01).tolist()
    spreads = [
        np.std(filtered(ComplementaryParameters(5.0, low), times, noise.tolist(), [0.0] * 2000))
        for low in (0.0, 0.1, 0.5)
    ]
    assert spreads[0] > 2.0 * spreads[1] > 2.0 * spreads[2]


def test_a_time_constant_of_0_is_s2() -> None:
    assert filtered(ComplementaryParameters(0.0), [0.0, 0.1], [5.0, 9.0], [1.0, 2.0]) == [1.0, 2.0]


def test_it_balances_the_pendulum_as_an_independent_simulation_found() -> None:
    method = complementary(ComplementaryParameters(0.2, s2_lags=True))
    runs = [simulate(method, Scenario(), np.random.default_rng(seed)) for seed in range(20)]
    times = np.arange(5000) * 0.01
    iae = np.mean([np.sum(np.abs(run.truth)) * 0.01 for run in runs])
    itae = np.mean([np.sum(times * np.abs(run.truth)) * 0.01 for run in runs])
    rms = np.mean([np.sqrt(np.mean((run.trace.value - run.truth) ** 2)) for run in runs])
    assert (iae, itae, rms) == (
        pytest.approx(0.645, rel=0.05),
        pytest.approx(14.7, rel=0.05),
        pytest.approx(0.0484, rel=0.05),
    )
