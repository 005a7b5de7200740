# SPDX-License-Identifier: Apache-2.0
"""S1 and S2 in constant shares."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.baselines import ConstantWeightParameters, constant_weight
from fuzzy_fusion_ros.parameters.errors import ParameterError

SECOND = 1_000_000_000


@pytest.mark.parametrize(
    ("weight", "expected"), [(0.0, 2.0), (0.25, 4.0), (0.5, 6.0), (0.75, 8.0), (1.0, 10.0)]
)
def test_the_shares_are_those_given(weight: float, expected: float) -> None:
    method = constant_weight(ConstantWeightParameters(weight))
    state = method.observe_s2(method.parameters, method.state, SECOND, 2.0)
    estimate, _ = method.update(method.parameters, state, 2 * SECOND, 10.0)
    assert (estimate.value, estimate.aggregate.weight) == (expected, weight)


def test_the_newest_s2_is_held() -> None:
    method = constant_weight(ConstantWeightParameters(0.0))
    state = method.state
    for value in (1.0, 2.0):
        state = method.observe_s2(method.parameters, state, SECOND, value)
    for stamp_ns in (SECOND, 100 * SECOND):
        estimate, state = method.update(method.parameters, state, stamp_ns, 7.0)
        assert estimate.value == 2.0


@pytest.mark.parametrize("weight", [-0.1, 1.1, float("nan")])
def test_a_weight_is_a_share(weight: float) -> None:
    with pytest.raises(ParameterError, match=r"weight: got .*, expected a number from 0 to 1"):
        ConstantWeightParameters(weight)
