"""Estimates of methods without rules: a value, and nothing to explain it."""

from __future__ import annotations

from fuzzy_fusion_ros.core.aggregator import single
from fuzzy_fusion_ros.core.estimator import FUSED, Estimate
from fuzzy_fusion_ros.core.gate import NO_PREDICTION


def bare_estimate(value: float) -> Estimate:
    """Return an estimate in rad, its explanation left empty."""
    return Estimate(
        mode=FUSED,
        value=value,
        aggregate=single(value, 0.0),
        prediction=NO_PREDICTION,
        accepted=False,
    )
