# SPDX-License-Identifier: Apache-2.0
"""The parameters of the fusion: every one, at every edge of its range."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import BreakPoints, Parameters, Weights
from fuzzy_fusion_ros.parameters.group import (
    Descriptor,
    Group,
    Value,
    descriptors,
    flatten,
    numbers,
    replace,
)

ALL = list(descriptors(Parameters))
NUMBERS = [(name, d) for name, d, _ in ALL if d.kind in (int, float)]
SWITCHES = [name for name, d, _ in ALL if d.kind is bool]
CHOICES = [(name, d) for name, d, _ in ALL if d.choices]

# Names that users' configurations rely on.
PINNED = """
    s1.type s1.field s1.timeout s2.type s2.field s2.timeout estimate.type estimate.field
    qos trigger rate
    aggregator.difference.small aggregator.difference.large
    aggregator.rate.small aggregator.rate.large aggregator.rate_time_constant
    aggregator.weight.very_small aggregator.weight.small
    aggregator.weight.large aggregator.weight.very_large
    aggregator.drift.small aggregator.drift.large
    predictor.enabled predictor.samples predictor.rules predictor.learning_rate
    predictor.error_threshold predictor.max_iterations
    gate.tolerance s1.lowpass_time_constant s1.bias_time_constant s1.bias_prior
    s1.drift_time_constant s1.drift_prior s2.noise
"""


def beyond(descriptor: Descriptor) -> list[float | int]:
    """Return the nearest numbers that a range leaves out."""
    if descriptor.kind is int:
        return [int(descriptor.low) - 1, int(descriptor.high) + 1]
    return [math.nextafter(descriptor.low, -math.inf), math.nextafter(descriptor.high, math.inf)]


def test_the_pinned_names_are_there() -> None:
    assert set(PINNED.split()) <= {name for name, _, _ in ALL}


@pytest.mark.parametrize(
    ("name", "default"),
    [
        ("trigger", "s1"),
        ("predictor.enabled", False),
        ("predictor.samples", 20),
        ("s1.lowpass_time_constant", 0.0),
        ("s1.bias_time_constant", 0.0),
        ("s1.type", "geometry_msgs/msg/PointStamped"),
        ("s2.type", "geometry_msgs/msg/PointStamped"),
        ("qos", "sensor_data"),
        ("record", ""),
    ],
)
def test_the_pinned_defaults(name: str, default: Value) -> None:
    assert flatten(Parameters())[name] == default


def test_defaults_are_those_of_the_descriptors() -> None:
    assert flatten(Parameters()) == {name: default for name, _, default in ALL}


@pytest.mark.parametrize(("name", "descriptor", "default"), ALL)
def test_every_descriptor_is_complete(name: str, descriptor: Descriptor, default: Value) -> None:
    assert descriptor.text == descriptor.text.strip() != ""
    assert type(default) is descriptor.kind
    assert descriptor.check(name, default) == default
    if descriptor.kind in (int, float):
        assert math.isfinite(descriptor.low)
        assert math.isfinite(descriptor.high)
        assert descriptor.low < descriptor.high


@pytest.mark.parametrize(("name", "descriptor"), NUMBERS)
def test_both_edges_of_a_range_belong_to_it(name: str, descriptor: Descriptor) -> None:
    for edge in (descriptor.low, descriptor.high):
        assert descriptor.check(name, descriptor.kind(edge)) == edge


@pytest.mark.parametrize(("name", "descriptor"), NUMBERS)
def test_nothing_beyond_a_range_is_taken(name: str, descriptor: Descriptor) -> None:
    for value in (*beyond(descriptor), math.nan, math.inf, -math.inf, 10**400, -(10**400)):
        with pytest.raises(ParameterError, match=rf"^parameter {name}: got .* from .* to "):
            replace(Parameters(), {name: value})


@pytest.mark.parametrize(("name", "descriptor"), NUMBERS)
def test_nothing_but_numbers_is_taken_for_a_number(name: str, descriptor: Descriptor) -> None:
    for value in (True, "1", None, [1.0], 1j):
        with pytest.raises(ParameterError, match=rf"^parameter {name}: got .*, expected an? "):
            replace(Parameters(), {name: value})


@pytest.mark.parametrize("name", [name for name, d in NUMBERS if d.kind is int])
def test_a_number_is_not_taken_for_an_integer(name: str) -> None:
    with pytest.raises(ParameterError, match=r"got 5.0, expected an integer from"):
        replace(Parameters(), {name: 5.0})


@pytest.mark.parametrize("name", SWITCHES)
@pytest.mark.parametrize("value", [0, 1, "true", None])
def test_only_booleans_are_taken_for_a_switch(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=rf"^parameter {name}: got .*, expected true or false"):
        replace(Parameters(), {name: value})


@pytest.mark.parametrize(("name", "descriptor"), CHOICES)
def test_only_choices_are_taken(name: str, descriptor: Descriptor) -> None:
    for choice in descriptor.choices:
        assert flatten(replace(Parameters(), {name: choice}))[name] == choice
    with pytest.raises(ParameterError, match=rf"^parameter {name}: got 'S1', expected one of "):
        replace(Parameters(), {name: "S1"})


def test_weights_that_do_not_rise_as_their_names_say_are_named() -> None:
    assert Weights().order_problem() == ""
    assert Weights(0.5, 0.5, 0.5, 0.5).order_problem() == ""
    assert "got 0.9, 0.3, 0.6, 0.8: " in Weights(0.9, 0.3, 0.6, 0.8).order_problem()


def test_the_triggers_are_those_that_users_rely_on() -> None:
    assert dict(CHOICES)["trigger"].choices == ("s1", "pair", "timer")
    assert dict(CHOICES)["qos"].choices == ("sensor_data", "reliable")


@pytest.mark.parametrize(("small", "large"), [(1.0, 1.0), (2.0, 1.0), (0.0, 0.0)])
def test_a_ramp_must_rise(small: float, large: float) -> None:
    with pytest.raises(ParameterError, match=rf"got {small}, expected less than large {large}"):
        BreakPoints(small, large)


@pytest.mark.parametrize("ramp", ["difference", "rate"])
def test_a_ramp_that_does_not_rise_is_named_in_full(ramp: str) -> None:
    name = f"aggregator.{ramp}"
    with pytest.raises(ParameterError, match=rf"^parameter {name}.small: got 9.0, expected less"):
        replace(Parameters(), {f"{name}.small": 9.0})
    moved = {f"{name}.small": 9.0, f"{name}.large": 10}
    assert getattr(replace(Parameters(), moved).aggregator, ramp) == BreakPoints(9.0, 10.0)


def test_flatten_and_replace_are_a_round_trip() -> None:
    changed = replace(
        Parameters(),
        {"trigger": "pair", "predictor.enabled": True, "gate.tolerance": 1, "s2.timeout": 0.25},
    )
    assert replace(Parameters(), flatten(changed)) == changed
    assert changed != Parameters()


def test_numbers_give_what_the_parameters_give() -> None:
    def compare(group: Group, plain: Any) -> None:
        for name, value in vars(group).items():
            if isinstance(value, Group):
                compare(value, getattr(plain, name))
            elif not isinstance(value, str | tuple):
                assert getattr(plain, name) == value
                assert type(getattr(plain, name)) is type(value)

    compare(Parameters(), numbers(Parameters()))
