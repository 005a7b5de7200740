# SPDX-License-Identifier: Apache-2.0
"""The numbers of the benchmark, pinned so that results compare across versions."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from fuzzy_fusion_ros.parameters.group import Group, group, real

if TYPE_CHECKING:
    from fuzzy_fusion_ros.batch.arrays import Stamps

Counts = TypeVar("Counts", int, "Stamps")

START_NS = 1_000_000_000
"""Stamp of the first sample, t = 0: a stamp of zero means *no stamp* in ROS."""


@dataclass(frozen=True)
class PlantParameters(Group):
    """Inverted pendulum on a cart."""

    gravity: float = real(9.8, "gravity", unit="m/s^2")
    cart_mass: float = real(1.0, "mass M of the cart", unit="kg", low=1e-3)
    pole_mass: float = real(0.1, "mass m of the pole", unit="kg", low=1e-3)
    half_length: float = real(0.5, "half the length of the pole, l", unit="m", low=1e-3)
    initial_angle: float = real(
        0.2, "angle at the start, 0 is upright", unit="rad", low=-1.5, high=1.5
    )
    initial_rate: float = real(
        0.0, "angular rate at the start", unit="rad/s", low=-100.0, high=100.0
    )


@dataclass(frozen=True)
class WidebandParameters(Group):
    """S1: fast, inaccurate."""

    bias: float = real(-0.03, "constant error of S1", unit="rad", low=-10.0, high=10.0)
    noise: float = real(0.05, "standard deviation of S1's white noise", unit="rad", high=10.0)


@dataclass(frozen=True)
class LaggedParameters(Group):
    """S2: accurate, slow."""

    time_constant: float = real(0.2, "time constant of S2's first-order lag", unit="s", high=100.0)
    noise: float = real(0.002, "standard deviation of S2's white noise", unit="rad", high=10.0)


@dataclass(frozen=True)
class ControllerParameters(Group):
    """Proportional-derivative control of the force on the cart."""

    proportional: float = real(40.0, "force per angle", unit="N/rad")
    derivative: float = real(10.0, "force per angular rate", unit="N s/rad")
    derivative_time_constant: float = real(0.02, "low-pass on the derivative", unit="s", high=10.0)
    limit: float = real(100.0, "largest force", unit="N")


@dataclass(frozen=True)
class DisturbanceParameters(Group):
    """A push on the cart."""

    start: float = real(25.0, "start of the push", unit="s")
    end: float = real(25.1, "end of the push", unit="s")
    force: float = real(-5.0, "force added to the cart by the push", unit="N", low=-1e3, high=1e3)


@dataclass(frozen=True)
class Scenario(Group):
    """One run of the benchmark; the defaults are its nominal point."""

    sample_time: float = real(0.01, "time between samples", unit="s", low=1e-4, high=1.0)
    duration: float = real(50.0, "length of the run", unit="s", low=1e-3, high=1e6)
    plant: PlantParameters = group(PlantParameters())
    s1_sensor: WidebandParameters = group(WidebandParameters())
    s2_sensor: LaggedParameters = group(LaggedParameters())
    controller: ControllerParameters = group(ControllerParameters())
    disturbance: DisturbanceParameters = group(DisturbanceParameters())


def samples_in(scenario: Scenario) -> int:
    """Return the number of samples of a run: from t = 0, the duration excluded."""
    return math.ceil(scenario.duration / scenario.sample_time - 1e-9)


def stamp_of(step_ns: int, k: Counts) -> Counts:
    """Return the stamp of sample ``k``, or of each of several, ``step_ns`` nanoseconds apart."""
    return START_NS + k * step_ns
