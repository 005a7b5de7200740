"""S1 and the held S2 in constant shares: either alone, their average, or any weight."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.baselines.parameters import ConstantWeightParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.aggregator import blend
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.parameters.group import numbers


class Held(NamedTuple):
    """The newest S2 sample, if there was any."""

    exists: bool
    value: float


def constant_weight(parameters: ConstantWeightParameters) -> Method:
    """Return the method."""
    return Method(observe_s2, update, numbers(parameters), Held(exists=False, value=0.0))


def observe_s2(
    parameters: ConstantWeightParameters, state: Held, stamp_ns: int, value: float
) -> Held:
    """Hold a sample of S2."""
    return Held(exists=True, value=value)


def update(
    parameters: ConstantWeightParameters, state: Held, stamp_ns: int, value: float
) -> tuple[Estimate, Held]:
    """Blend a sample of S1 with S2 as held."""
    if not state.exists:
        return waiting(), state
    mixed = blend(parameters.weight, value, state.value)
    return estimated(mixed, parameters.weight), state
