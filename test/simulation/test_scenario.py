# SPDX-License-Identifier: Apache-2.0
"""The benchmark's numbers, which are pinned."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.group import descriptors, flatten, replace
from fuzzy_fusion_ros.simulation.scenario import START_NS, Scenario, samples_in, stamp_of

PINNED = {
    "sample_time": 0.01,
    "duration": 50.0,
    "plant.gravity": 9.8,
    "plant.cart_mass": 1.0,
    "plant.pole_mass": 0.1,
    "plant.half_length": 0.5,
    "plant.initial_angle": 0.2,
    "plant.initial_rate": 0.0,
    "s1_sensor.bias": -0.03,
    "s1_sensor.noise": 0.05,
    "s2_sensor.time_constant": 0.2,
    "s2_sensor.noise": 0.002,
    "controller.proportional": 40.0,
    "controller.derivative": 10.0,
    "controller.derivative_time_constant": 0.02,
    "controller.limit": 100.0,
    "disturbance.start": 25.0,
    "disturbance.end": 25.1,
    "disturbance.force": -5.0,
}


def test_the_nominal_point_is_pinned() -> None:
    assert flatten(Scenario()) == PINNED


def test_every_number_is_described() -> None:
    for name, descriptor, default in descriptors(Scenario):
        assert descriptor.text
        assert descriptor.unit, name
        assert descriptor.check(name, default) == default


def test_what_makes_no_plant_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"plant\.pole_mass: got 0\.0, expected a number from"):
        replace(Scenario(), {"plant.pole_mass": 0.0})


@pytest.mark.parametrize(
    ("sample_time", "duration", "samples"),
    [
        (0.01, 50.0, 5000),
        (0.01, 0.01, 1),
        (0.01, 0.011, 2),
        (0.1, 0.3, 3),
        (0.1, 0.7, 7),
        (0.003, 1.0, 334),
        (1e-4, 1e3, 10_000_000),
    ],
)
def test_the_end_of_the_duration_does_not_belong_to_it(
    sample_time: float, duration: float, samples: int
) -> None:
    changed = replace(Scenario(), {"sample_time": sample_time, "duration": duration})
    assert samples_in(changed) == samples


def test_no_stamp_is_zero_and_all_are_exact() -> None:
    assert stamp_of(10_000_000, 0) == START_NS > 0
    assert stamp_of(10_000_000, 4999) - START_NS == 49_990_000_000
