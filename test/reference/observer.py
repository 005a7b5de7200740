# SPDX-License-Identifier: Apache-2.0
"""The observer with matrices, one plain loop: an oracle for ``core.observer``.

Without spikes, low-pass and gaps of S1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.parameters.fusion import Parameters

Samples = Sequence[tuple[int, float]]


def observed(parameters: Parameters, s1: Samples, s2: Samples, known: Sequence[int]) -> list[float]:
    """Return the estimate at every sample of S1.

    Args:
        parameters: Of the fusion; the bias is learnt, S2's noise and the prior are known.
        s1, s2: Stamps in nanoseconds, and values.
        known: How many samples of S2 come before each of S1.
    """
    noise = parameters.s2.noise
    c = b = l1 = m1 = m2 = 0.0
    past: list[tuple[int, float]] = []  # S1 behind the lag
    full = np.array([1.0, 0.0, 1.0, 1.0])
    p = np.outer(full, full) * (parameters.s1.bias_prior / noise) ** 2
    if parameters.s1.drift_time_constant > 0.0:
        p[1, 1] = (parameters.s1.drift_prior / noise) ** 2
    rate = interval = held = 0.0
    held_ns = at_ns = 0
    said: list[float] = []
    seen = 0
    believed = -1
    for k, (stamp_ns, value) in enumerate(s1):
        while seen < known[k]:
            z_ns, z = s2[seen]
            if seen > 0:
                dt = (z_ns - held_ns) * 1e-9
                t_r = parameters.aggregator.rate_time_constant
                rate = (t_r * rate + z - held) / (t_r + dt)
                interval = (
                    dt if interval == 0.0 else interval + 0.1 * (min(dt, 3 * interval) - interval)
                )
            held_ns, held = z_ns, z
            seen += 1
            if k > 0:
                d = max((z_ns - at_ns) * 1e-9, 0.0)
                at_ns = max(at_ns, z_ns)
                p = _walked(parameters, p, interval, d)
                e = _delayed(past, z_ns, parameters.s2.delay) - m2 - z
                c, b, m1, m2, p = _corrected(parameters, p, (c, b, m1, m2), e, rate)
                believed = seen
        if k == 0:
            l1 = value
            m1 = m2 = c
            past.append((stamp_ns, l1))
            at_ns = stamp_ns
            if seen > believed and seen:
                d = max((held_ns - at_ns) * 1e-9, 0.0)
                p = _walked(parameters, p, interval, d)
                e = _delayed(past, held_ns, parameters.s2.delay) - m2 - held
                c, b, m1, m2, p = _corrected(parameters, p, (c, b, m1, m2), e, rate)
        else:
            dt = (stamp_ns - s1[k - 1][0]) * 1e-9
            c += b * dt
            l1 += _gain(dt, parameters.s2.lag_time_constant) * (value - l1)
            past.append((stamp_ns, l1))
            m1 += _gain(dt, parameters.s2.lag_time_constant) * (c - m1)
            m2 += _gain(dt, parameters.s2.delay) * (m1 - m2)
        said.append(value - c)
    return said


def _delayed(past: Samples, stamp_ns: int, delay: float) -> float:
    times = [(stamp - past[-1][0]) * 1e-9 for stamp, _ in past]
    wanted = (stamp_ns - past[-1][0]) * 1e-9 - delay
    return float(np.interp(wanted, times, [value for _, value in past]))


def _gain(dt: float, time_constant: float) -> float:
    return 1.0 if time_constant == 0.0 else 1.0 - math.exp(-dt / time_constant)


def _walked(
    parameters: Parameters, p: NDArray[np.float64], interval: float, d: float
) -> NDArray[np.float64]:
    a, h = _gain(d, parameters.s2.lag_time_constant), _gain(d, parameters.s2.delay)
    transition = np.array(
        [
            [1.0, d, 0.0, 0.0],
            [0.0, 1.0, 0.0, 0.0],
            [a, 0.0, 1.0 - a, 0.0],
            [h * a, 0.0, h * (1.0 - a), 1.0 - h],
        ]
    )
    walk = interval * d / parameters.s1.bias_time_constant**2
    p = p.copy()
    p[0, 0] += walk
    p = transition @ p @ transition.T
    if parameters.s1.drift_time_constant > 0.0:
        turn = walk / parameters.s1.drift_time_constant**2
        p[:2, :2] += turn * np.array([[d * d / 3.0, d / 2.0], [d / 2.0, 1.0]])
    return p


def _corrected(
    parameters: Parameters, p: NDArray[np.float64], state: tuple[float, ...], e: float, rate: float
) -> tuple[float, float, float, float, NDArray[np.float64]]:
    c, b, m1, m2 = state

    def large(x: float, small: float, large: float) -> float:
        return min(max((x - small) / (large - small), 0.0), 1.0)

    aggregator = parameters.aggregator
    d = large(abs(e), aggregator.difference.small, aggregator.difference.large)
    r = large(abs(rate), aggregator.rate.small, aggregator.rate.large)
    weight = aggregator.weight
    w1 = (
        (1 - d) * (1 - r) * weight.small
        + (1 - d) * r * weight.large
        + d * (1 - r) * weight.very_small
        + d * r * weight.very_large
    )
    variance = 1.0 / (1.0 - w1) ** 2
    full = np.array([1.0, 0.0, 1.0, 1.0])
    p = p + d * (1 - r) * (e / parameters.s2.noise) ** 2 * np.outer(full, full)
    k = p[:, 3] / (p[3, 3] + variance)
    p = p - np.outer(k, p[3])
    return c + k[0] * e, b + k[1] * e, m1 + k[2] * e, m2 + k[3] * e, p
