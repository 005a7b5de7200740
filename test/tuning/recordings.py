# SPDX-License-Identifier: Apache-2.0
"""Small made-up recordings whose sensors are known."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import Series

START_NS = 1_000_000_000


class Sensors(NamedTuple):
    """What the sensors of a recording are like.

    Attributes:
        bias: Of S1.
        drift: Of S1, a second.
        noise: Standard deviation of S1's.
        spikes: Share of S1's samples that are spikes.
        delay: Of S2, s.
        lag: Time constant of S2, s.
        gap: Begin and end of a gap in S2, s.
    """

    bias: float = 0.3
    drift: float = 0.0
    noise: float = 0.05
    spikes: float = 0.0
    delay: float = 0.0
    lag: float = 0.4
    gap: tuple[float, float] = (0.0, 0.0)


class Made(NamedTuple):
    """A recording and its truth.

    Attributes:
        series: The recording.
        truth: At each S1 sample, shape (n,).
    """

    series: Series
    truth: Reals


def made(sensors: Sensors, seed: int = 0, seconds: float = 40.0, rate: float = 25.0) -> Made:
    """Make a recording of a signal that rests now and then; S2 has a fifth of S1's rate."""
    generator = np.random.default_rng(seed)
    n = round(seconds * rate)
    s1_s = np.arange(n) / rate
    moving = np.sin(0.25 * s1_s) > -0.3
    truth = np.where(moving, np.sin(1.3 * s1_s) + 0.5 * np.sin(2.9 * s1_s), 0.0)
    truth = _lagged(truth, s1_s, 0.2)
    s1 = truth + sensors.bias + sensors.drift * s1_s + sensors.noise * generator.standard_normal(n)
    spikes = generator.random(n) < sensors.spikes
    s1[spikes] += generator.choice([-1.0, 1.0], n)[spikes] * 4.0
    s2_s = np.arange(0.2, seconds, 5.0 / rate)
    s2_s = s2_s[(s2_s < sensors.gap[0]) | (s2_s >= sensors.gap[1])]
    s2 = np.interp(s2_s - sensors.delay, s1_s, _lagged(truth, s1_s, sensors.lag))
    s2 += 0.002 * generator.standard_normal(s2.size)
    s1_ns, s2_ns = (START_NS + np.round(each * 1e9).astype(np.int64) for each in (s1_s, s2_s))
    known = np.searchsorted(s2_ns, s1_ns, side="right").astype(np.int64)
    return Made(Series(s1_ns, s1, s2_ns, s2, known), truth)


def _lagged(values: Reals, time_s: Reals, time_constant: float) -> Reals:
    found = values.copy()
    for k in range(1, values.size):
        share = 1.0 - np.exp(-(time_s[k] - time_s[k - 1]) / time_constant) if time_constant else 1.0
        found[k] = found[k - 1] + share * (values[k] - found[k - 1])
    return found
