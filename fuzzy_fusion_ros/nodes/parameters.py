# SPDX-License-Identifier: Apache-2.0
"""Parameters of the nodes that are no parameters of the fusion."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzy_fusion_ros.parameters.fusion import SensorParameters
from fuzzy_fusion_ros.parameters.group import Group, group, integer, real, switch, text
from fuzzy_fusion_ros.simulation.scenario import Scenario

FEEDBACKS = ("estimate", "s1", "s2", "average", "truth")


@dataclass(frozen=True)
class PendulumParameters(Scenario):
    """The benchmark as a node: what it simulates, and how it runs."""

    feedback: str = text(
        "estimate",
        "signal that the controller acts on; average is that of S1 and S2",
        choices=FEEDBACKS,
    )
    seed: int = integer(0, "seed of the sensors' noise", low=0, high=2**31 - 1)
    real_time_factor: float = real(
        0.0,
        "simulated seconds per second; 0: lockstep, each sample waits for its estimate",
        high=1e3,
    )
    publish_clock: bool = switch(False, "publish the simulated time on /clock")
    timeout: float = real(
        10.0, "how long to wait for peers, then for each estimate", unit="s", low=0.01, high=1e6
    )
    record: str = text("", "bag directory to record all topics to; empty: none")


@dataclass(frozen=True)
class SubscriberParameters(Group):
    """One sensor, taken from any message type."""

    input: SensorParameters = group(SensorParameters())
    future_tolerance: float = real(
        10.0, "samples stamped further ahead of the clock than this are dropped", unit="s"
    )
    qos: str = text(
        "sensor_data",
        "quality of service of the input: best effort or reliable delivery",
        choices=("sensor_data", "reliable"),
    )
