"""S1 alone, S2 alone or their average: the paper's Figs 6-9."""

from __future__ import annotations

from fuzzy_fusion_ros.core.aggregator import blend
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.series import Method
from fuzzy_fusion_ros.simulation.bare import bare_estimate


def constant_weight(weight: float) -> Method:
    """Return eq. (1) with a weight of S1 that never changes, 0 to 1, as a method."""
    return Method(observe_s2, update, weight, 0.0)


def observe_s2(weight: float, held: float, stamp_ns: int, value: float) -> float:
    """Hold a sample of S2; one comes before the first of S1."""
    return value


def update(weight: float, held: float, stamp_ns: int, value: float) -> tuple[Estimate, float]:
    """Blend a sample of S1 with S2 as held."""
    return bare_estimate(blend(weight, value, held)), held
