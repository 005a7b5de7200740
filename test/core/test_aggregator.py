# SPDX-License-Identifier: Apache-2.0
"""The fuzzy aggregator against its reference and its invariants."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from reference import aggregator as reference
from searching import examples

from fuzzy_fusion_ros.core.aggregator import (
    aggregate,
    blend,
    defuzzify,
    firing_strengths,
    sign,
    single,
)
from fuzzy_fusion_ros.parameters.fusion import (
    AggregatorParameters,
    BreakPoints,
    Drifts,
    Weights,
)

PINNED = AggregatorParameters(
    difference=BreakPoints(0.0, 0.3),
    rate=BreakPoints(0.0, 1.0),
    rate_time_constant=0.03,
    weight=Weights(very_small=0.0, small=0.05, large=0.3, very_large=0.7),
    drift=Drifts(small=0.0, large=0.1),
)

FINITE = st.floats(allow_nan=False, allow_infinity=False)
SHARE = st.floats(0.0, 1.0)
BREAK_POINTS = st.lists(st.floats(0.0, 1e9), min_size=2, max_size=2, unique=True).map(
    lambda pair: BreakPoints(min(pair), max(pair))
)
PARAMETERS = st.builds(
    AggregatorParameters,
    difference=BREAK_POINTS,
    rate=BREAK_POINTS,
    weight=st.builds(Weights, SHARE, SHARE, SHARE, SHARE),
    drift=st.builds(Drifts, st.floats(0.0, 1e9), st.floats(0.0, 1e9)),
)


def setting_of(parameters: AggregatorParameters) -> reference.Setting:
    """Return parameters as the reference takes them."""
    return reference.Setting(
        difference=(parameters.difference.small, parameters.difference.large),
        rate=(parameters.rate.small, parameters.rate.large),
        weight=vars(parameters.weight),
        drift=vars(parameters.drift),
    )


def random_parameters(generator: np.random.Generator) -> AggregatorParameters:
    """Draw parameters of everyday size."""
    difference = sorted(float(x) for x in generator.uniform(0.0, 1.0, 2))
    rate = sorted(float(x) for x in generator.uniform(0.0, 3.0, 2))
    return AggregatorParameters(
        difference=BreakPoints(*difference),
        rate=BreakPoints(*rate),
        weight=Weights(*(float(x) for x in generator.uniform(0.0, 1.0, 4))),
        drift=Drifts(*(float(x) for x in generator.uniform(0.0, 0.5, 2))),
    )


@pytest.mark.parametrize(
    ("difference", "rate", "weight", "drift"),
    [
        (0.0, 0.0, "small", "small"),
        (0.0, 1.0, "large", "large"),
        (0.3, 0.0, "very_small", "small"),
        (0.3, 1.0, "very_large", "small"),
        (1e300, 1e300, "very_large", "small"),
    ],
)
def test_each_rule_of_table_1_alone(
    difference: float, rate: float, weight: str, drift: str
) -> None:
    said = aggregate(PINNED, difference, 0.0, rate)
    assert said.weight == getattr(PINNED.weight, weight)
    assert said.drift == getattr(PINNED.drift, drift)
    assert sorted(said.strengths) == [0.0, 0.0, 0.0, 1.0]


def test_strengths_stand_in_the_order_of_table_1() -> None:
    strengths = firing_strengths(0.3, 0.25, PINNED.difference, PINNED.rate)
    assert strengths == (0.0, 0.0, 0.75, 0.25)
    assert strengths._fields == ("small_small", "small_large", "large_small", "large_large")


@pytest.mark.parametrize(
    ("x", "expected"),
    [(2.0, 1.0), (5e-324, 1.0), (0.0, 0.0), (-0.0, 0.0), (-5e-324, -1.0), (-1e300, -1.0)],
)
def test_sign(x: float, expected: float) -> None:
    assert sign(x) == expected


@pytest.mark.parametrize("rate", [0.0, -0.0])
def test_without_motion_there_is_no_drift(rate: float) -> None:
    everywhere = AggregatorParameters(drift=Drifts(small=0.5, large=0.5))
    assert aggregate(everywhere, 1.0, 1.0, rate).value == 1.0


@pytest.mark.parametrize(("rate", "expected"), [(10.0, 0.1), (-10.0, -0.1)])
def test_drift_goes_with_the_motion(rate: float, expected: float) -> None:
    assert aggregate(PINNED, 0.0, 0.0, rate).value == pytest.approx(expected)


def test_the_defuzzifier_is_the_weighted_mean_of_its_levels() -> None:
    strengths = firing_strengths(0.15, 0.5, PINNED.difference, PINNED.rate)
    assert defuzzify(strengths, 1.0, 2.0, 3.0, 6.0) == pytest.approx(3.0)


def test_random_inputs_give_what_the_reference_gives() -> None:
    generator = np.random.default_rng(1)
    for _ in range(300):
        parameters = random_parameters(generator)
        setting = setting_of(parameters)
        for s1, s2, rate in generator.normal(0.0, [0.5, 0.5, 2.0], (10, 3)).tolist():
            said = aggregate(parameters, s1, s2, rate)
            exact = reference.aggregate(setting, s1, s2, rate)
            assert said.value == pytest.approx(float(exact.value), rel=1e-12, abs=1e-14)
            assert said.weight == pytest.approx(float(exact.weight), rel=1e-12, abs=1e-14)
            assert said.drift == pytest.approx(float(exact.drift), rel=1e-12, abs=1e-14)
            assert said.strengths == pytest.approx([float(s) for s in exact.strengths], abs=1e-14)


@given(st.floats(0.0, allow_infinity=True), st.floats(0.0, allow_infinity=True), PARAMETERS)
def test_strengths_are_shares_of_one(
    difference: float, rate: float, parameters: AggregatorParameters
) -> None:
    strengths = firing_strengths(difference, rate, parameters.difference, parameters.rate)
    assert all(0.0 <= strength <= 1.0 for strength in strengths)
    assert math.fsum(strengths) == pytest.approx(1.0, rel=1e-15)


@examples(1000)
@given(PARAMETERS, FINITE, FINITE, FINITE)
@example(PINNED, 1.7e308, -1.7e308, 1.7e308)
@example(PINNED, 1.7976931348623157e308, 1.7976931348623157e308, -1.0)
@example(PINNED, 5e-324, -5e-324, 5e-324)
@example(PINNED, -0.0, 0.0, -0.0)
def test_the_output_stays_between_the_sensors_but_for_the_drift(
    parameters: AggregatorParameters, s1: float, s2: float, rate: float
) -> None:
    """Invariant 4, for all that is finite: also where sums and differences overflow."""
    said = aggregate(parameters, s1, s2, rate)
    assert math.isfinite(said.value)
    assert min(s1, s2) - said.drift <= said.value <= max(s1, s2) + said.drift
    assert 0.0 <= said.weight <= 1.0
    assert 0.0 <= said.drift <= max(vars(parameters.drift).values()) * (1.0 + 1e-15)


def test_the_weight_is_a_share_even_where_rounding_is_against_it() -> None:
    everywhere = AggregatorParameters(weight=Weights(1.0, 1.0, 1.0, 1.0))
    generator = np.random.default_rng(2)
    for s1, rate in generator.uniform(0.0, [0.3, 1.0], (10_000, 2)).tolist():
        assert aggregate(everywhere, s1, 0.0, rate).weight <= 1.0


@given(SHARE, FINITE, FINITE)
def test_a_blend_lies_between(weight: float, s1: float, s2: float) -> None:
    assert min(s1, s2) <= blend(weight, s1, s2) <= max(s1, s2)
    assert blend(1.0, s1, s2) == s1
    assert blend(0.0, s1, s2) == s2


@pytest.mark.parametrize("weight", [1.0, 0.0])
def test_one_sensor_alone_fires_no_rule(weight: float) -> None:
    alone = single(0.5, weight)
    assert alone == (0.5, weight, 0.0, (0.0, 0.0, 0.0, 0.0))
