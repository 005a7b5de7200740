# SPDX-License-Identifier: Apache-2.0
"""The sensors: S1 wideband and inaccurate, S2 accurate and slow."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.core.numerics import lag_gain
from fuzzy_fusion_ros.simulation.scenario import LaggedParameters, WidebandParameters


def draw_noise(generator: np.random.Generator, samples: int) -> Reals:
    """Draw a run's standard normal noise, shape (samples, 2): S1's and S2's, sample by sample."""
    return generator.standard_normal((samples, 2))


def read_s1(sensor: WidebandParameters, angle: float, noise: float) -> float:
    """Return S1's reading of ``angle`` in rad, given a standard normal number."""
    return angle + sensor.bias + sensor.noise * noise


def follow(sensor: LaggedParameters, lagged: float, angle: float, dt: float) -> float:
    """Advance S2's first-order lag by ``dt`` seconds towards ``angle``."""
    return lagged + lag_gain(dt, sensor.time_constant) * (angle - lagged)


def read_s2(sensor: LaggedParameters, lagged: float, noise: float) -> float:
    """Return S2's reading of its lagged angle in rad, given a standard normal number."""
    return lagged + sensor.noise * noise
