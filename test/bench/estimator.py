# SPDX-License-Identifier: Apache-2.0
"""One update of the estimator, against a Kalman filter and other engines for the same rules."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from bench.effort import Effort
from bench.measuring import compared, cpu_seconds, interleaved
from bench.other_rules import in_scikit_fuzzy, in_simpful
from bench.table import Aim, Row, at_most
from fuzzy_fusion_ros.core.aggregator import aggregate
from fuzzy_fusion_ros.core.estimator import initial_state, observe_s2, update
from fuzzy_fusion_ros.parameters.fusion import AggregatorParameters, Parameters
from fuzzy_fusion_ros.parameters.group import replace

STEP_NS = 10_000_000
S2_EVERY = 10
"""A sample of S2 comes with every tenth of S1; its cost is in the figures."""

FA = Parameters()
COMPLETE = replace(FA, {"predictor.enabled": True})


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time per update; rivals are in Python, as the method is unless compiled."""
    s1, s2 = signals(max(effort.steps, effort.slow_steps))
    n, few = effort.steps, effort.slow_steps
    fa, complete, rules, kalman, scalar, two_states, simpful, scikit = interleaved(
        effort.repetitions,
        lambda: estimate(FA, s1[:n], s2[:n]),
        lambda: estimate(COMPLETE, s1[:n], s2[:n]),
        lambda: infer_here(FA.aggregator, s1[:n], s2[:n]),
        lambda: kalman_filter(s1[:n]),
        lambda: scalar_kalman(s1[:n]),
        lambda: two_state_kalman(s1[:n]),
        lambda: each(in_simpful(FA.aggregator), s1[:few], s2[:few]),
        lambda: each(in_scikit_fuzzy(FA.aggregator), s1[:few], s2[:few]),
    )
    kalman_name = "filterpy, predict + update"
    by_hand = "Kalman filter by hand"
    return [
        _row("update, FA alone", fa, kalman, kalman_name, at_most(0.1)),
        _row("update, FA alone", fa, scalar, f"{by_hand}, 1 state"),
        _row("update, FA alone", fa, two_states, f"{by_hand}, 2 states"),
        _row("update, complete (n = 20)", complete, kalman, kalman_name, at_most(0.3)),
        _row("update, complete (n = 20)", complete, two_states, f"{by_hand}, 2 states"),
        _row("rules of Table 1: `aggregate`", rules, simpful, "simpful, `Sugeno_inference`"),
        _row("rules of Table 1: `aggregate`", rules, scikit, "scikit-fuzzy, `compute`"),
    ]


def _row(
    what: str, ours: list[float], others: list[float], name: str, aim: Aim | None = None
) -> Row:
    it = compared(ours, others)
    return Row(
        f"{what}, CPU",
        f"{it.ours * 1e6:.2f} µs",
        f"{it.against * 1e6:.1f} µs {name}",
        it.ratio,
        aim,
    )


def signals(n: int) -> tuple[list[float], list[float]]:
    """Return samples of S1 and S2 that move and are noisy, so that the predictor trains."""
    noise = np.random.default_rng(0).normal(0.0, [0.05, 0.002], (n, 2)).tolist()
    truth = [0.3 * math.sin(0.05 * k) for k in range(n)]
    s1 = [x + each[0] for x, each in zip(truth, noise, strict=True)]
    return s1, [x + each[1] for x, each in zip(truth, noise, strict=True)]


def estimate(parameters: Parameters, s1: list[float], s2: list[float]) -> float:
    """Return seconds per sample of S1."""
    state = observe_s2(parameters, initial_state(parameters), STEP_NS, s2[0])

    def work() -> None:
        nonlocal state
        stamp_ns = STEP_NS
        for k, value in enumerate(s1):
            stamp_ns += STEP_NS
            if k % S2_EVERY == 0:
                state = observe_s2(parameters, state, stamp_ns, s2[k])
            _, state = update(parameters, state, stamp_ns, value)

    return cpu_seconds(work) / len(s1)


def infer_here(parameters: AggregatorParameters, s1: list[float], s2: list[float]) -> float:
    """Return seconds per inference of the aggregator."""

    def infer(difference: float, rate: float) -> tuple[float, float]:
        said = aggregate(parameters, difference, 0.0, rate)
        return said.weight, said.drift

    return each(infer, s1, s2)


def kalman_filter(samples: list[float]) -> float:
    """Return seconds per predict and update of filterpy: constant velocity, position measured."""
    from filterpy.kalman import KalmanFilter

    kalman = KalmanFilter(dim_x=2, dim_z=1)
    kalman.F = np.array([[1.0, STEP_NS * 1e-9], [0.0, 1.0]])
    kalman.H = np.array([[1.0, 0.0]])
    kalman.R *= 0.05**2
    kalman.Q *= 0.01

    def work() -> None:
        for value in samples:
            kalman.predict()
            kalman.update(value)

    return cpu_seconds(work) / len(samples)


def scalar_kalman(samples: list[float]) -> float:
    """Return seconds per sample of a random walk, as one would write it in a node."""

    def work() -> None:
        x, p = 0.0, 1.0
        for value in samples:
            p += 1e-4
            gain = p / (p + 0.05**2)
            x += gain * (value - x)
            p *= 1.0 - gain

    return cpu_seconds(work) / len(samples)


def two_state_kalman(samples: list[float]) -> float:
    """Return seconds per sample at constant velocity, in plain numbers."""
    dt = STEP_NS * 1e-9

    def work() -> None:
        x, v, xx, xv, vv = 0.0, 0.0, 1.0, 0.0, 1.0
        for value in samples:
            x += dt * v
            xx += dt * (2.0 * xv + dt * vv) + 1e-6
            xv += dt * vv
            vv += 0.01
            total = xx + 0.05**2
            gain_x, gain_v, error = xx / total, xv / total, value - x
            x += gain_x * error
            v += gain_v * error
            vv -= gain_v * xv
            xv -= gain_x * xv
            xx -= gain_x * xx

    return cpu_seconds(work) / len(samples)


def each(infer: Callable[[float, float], object], s1: list[float], s2: list[float]) -> float:
    """Return seconds per inference."""
    inputs = [(abs(x - y), abs(y)) for x, y in zip(s1, s2, strict=True)]

    def work() -> None:
        for difference, rate in inputs:
            infer(difference, rate)

    return cpu_seconds(work) / len(inputs)
