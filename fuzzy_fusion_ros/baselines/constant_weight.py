# SPDX-License-Identifier: Apache-2.0
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
    """The newest sample of either sensor, if there was any.

    Attributes:
        s1_samples: Samples of S1 so far.
        s1: The newest.
        s2_samples: Samples of S2 so far.
        s2: The newest.
    """

    s1_samples: int
    s1: float
    s2_samples: int
    s2: float


def constant_weight(parameters: ConstantWeightParameters) -> Method:
    """Return the method."""
    state = Held(s1_samples=0, s1=0.0, s2_samples=0, s2=0.0)
    return Method(observe_s2, update, without_s1, numbers(parameters), state)


def observe_s2(
    parameters: ConstantWeightParameters, state: Held, stamp_ns: int, value: float
) -> Held:
    """Hold a sample of S2."""
    return Held(state.s1_samples, state.s1, state.s2_samples + 1, value)


def update(
    parameters: ConstantWeightParameters, state: Held, stamp_ns: int, value: float
) -> tuple[Estimate, Held]:
    """Blend a sample of S1 with S2 as held."""
    kept = Held(state.s1_samples + 1, value, state.s2_samples, state.s2)
    if state.s2_samples == 0:
        return waiting(), kept
    return estimated(blend(parameters.weight, value, state.s2), parameters.weight), kept


def without_s1(parameters: ConstantWeightParameters, state: Held, stamp_ns: int) -> Estimate:
    """Blend a sample of S2 that has been observed with S1 as held."""
    if state.s1_samples == 0:
        return waiting()
    return estimated(blend(parameters.weight, state.s1, state.s2), parameters.weight)
