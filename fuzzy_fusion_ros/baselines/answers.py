# SPDX-License-Identifier: Apache-2.0
"""Estimates of the baselines: a value without rules that explain it."""

from __future__ import annotations

import math

from fuzzy_fusion_ros.core.aggregator import single
from fuzzy_fusion_ros.core.estimator import FUSED, WAITING, Estimate
from fuzzy_fusion_ros.core.gate import NO_PREDICTION
from fuzzy_fusion_ros.core.numerics import LARGEST

LEAST = 1e-24
"""A variance below the square of the least noise is 0, or a rounding error of 0."""


def estimated(value: float, weight: float, variance: float = 0.0) -> Estimate:
    """Return an estimate.

    Args:
        value: The estimate, finite.
        weight: The share of S1 in the step, for the trace.
        variance: Of the estimate's error, unit of the signal squared; not known below ``LEAST``.
    """
    deviation = math.sqrt(min(variance, LARGEST)) if variance > LEAST else 0.0
    return _estimate(FUSED, value, weight, deviation)


def waiting() -> Estimate:
    """Return the placeholder for no estimate, while a sensor has not been heard."""
    return _estimate(WAITING, 0.0, 0.0, 0.0)


def _estimate(mode: int, value: float, weight: float, deviation: float) -> Estimate:
    return Estimate(
        mode=mode,
        value=value,
        aggregate=single(value, weight),
        prediction=NO_PREDICTION,
        accepted=False,
        standard_deviation=deviation,
    )
