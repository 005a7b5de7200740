# SPDX-License-Identifier: Apache-2.0
"""Estimates of the baselines: a value without rules that explain it."""

from __future__ import annotations

from fuzzy_fusion_ros.core.aggregator import single
from fuzzy_fusion_ros.core.estimator import FUSED, WAITING, Estimate
from fuzzy_fusion_ros.core.gate import NO_PREDICTION


def estimated(value: float, weight: float) -> Estimate:
    """Return an estimate; baselines do not know its standard deviation.

    Args:
        value: The estimate, finite.
        weight: The share of S1 in the step, for the trace.
    """
    return _estimate(FUSED, value, weight)


def waiting() -> Estimate:
    """Return the placeholder for no estimate, while a sensor has not been heard."""
    return _estimate(WAITING, 0.0, 0.0)


def _estimate(mode: int, value: float, weight: float) -> Estimate:
    return Estimate(
        mode=mode,
        value=value,
        aggregate=single(value, weight),
        prediction=NO_PREDICTION,
        accepted=False,
        standard_deviation=0.0,
    )
