# SPDX-License-Identifier: Apache-2.0
"""Bags of real message types for the presets in config/: simulated sensors and their truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.core.periodic import nearest
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec, default_message
from fuzzy_fusion_ros.messages.variances import Elements
from fuzzy_fusion_ros.offline.topics import Topics

SECONDS = 120.0
BEGIN_NS = 1_700_000_000_000_000_000
TURN = 2.0 * math.pi
POINT = "geometry_msgs/msg/PointStamped"


class Sensor(NamedTuple):
    """A sensor of a preset.

    Attributes:
        topic: Where its driver publishes.
        type_name: The type.
        rate: Hz.
        fields: What a message holds at some time, by path, given two standard normal numbers.
    """

    topic: str
    type_name: str
    rate: float
    fields: Callable[[float, float, float], Mapping[str, float]]


class Rig(NamedTuple):
    """What a preset is for.

    Attributes:
        s1: The fast sensor.
        s2: The accurate one.
        truths: What both measure, at some time, by channel; ``""`` where there is one.
    """

    s1: Sensor
    s2: Sensor
    truths: Mapping[str, Callable[[float], float]]


def heading(t: float) -> float:
    return nearest(0.3 * t + 1.2 * math.sin(0.4 * t), 0.0, TURN)


def pitch(t: float) -> float:
    return 0.4 * math.sin(0.7 * t) + 0.2 * math.sin(1.9 * t)


def speed(t: float) -> float:
    return 6.0 + 3.0 * math.sin(0.3 * t) + math.sin(0.9 * t)


def height(t: float) -> float:
    return 8.0 + 4.0 * math.sin(0.2 * t) + math.sin(0.7 * t)


def temperature(t: float, lag: float = 0.0) -> float:
    """A sum of two sines, as it shows through a first-order lag, deg C."""

    def seen(size: float, pulse: float) -> float:
        return (
            size * math.cos(math.atan(pulse * lag)) * math.sin(pulse * t - math.atan(pulse * lag))
        )

    return 20.0 + seen(4.0, 0.1) + seen(1.5, 0.4)


POSITION: Mapping[str, Callable[[float], float]] = {
    "x": lambda t: 20.0 * math.sin(0.15 * t) + 3.0 * math.sin(0.6 * t),
    "y": lambda t: 15.0 * math.cos(0.2 * t),
    "z": lambda t: 2.0 * math.sin(0.1 * t) + 0.3 * math.sin(0.9 * t),
}


def _odometry(t: float, a: float, b: float) -> Mapping[str, float]:
    drift = 0.02 * t + 0.4 * math.sin(0.05 * t)
    noises = 0.01 * a, 0.01 * b, 0.007 * (a - b)
    return {
        f"pose.pose.position.{axis}": at(t) + drift + noise
        for (axis, at), noise in zip(POSITION.items(), noises, strict=True)
    }


def _fix(t: float, a: float, b: float) -> Mapping[str, float]:
    noises = 0.3 * a, 0.3 * b, 0.42 * (a - b)
    return {
        f"pose.pose.position.{axis}": at(t - 0.1) + noise
        for (axis, at), noise in zip(POSITION.items(), noises, strict=True)
    }


def _gnss(t: float, a: float, b: float) -> Mapping[str, float]:
    course = heading(t - 0.3)
    return {
        "twist.twist.linear.x": 8.0 * math.cos(course) + 0.2 * a,
        "twist.twist.linear.y": 8.0 * math.sin(course) + 0.2 * b,
    }


def _gyro_z(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"angular_velocity.z": 0.3 + 0.48 * math.cos(0.4 * t) + 0.01 + 0.01 * a}


def _tilting(t: float, a: float, b: float) -> Mapping[str, float]:
    rate = 0.28 * math.cos(0.7 * t) + 0.38 * math.cos(1.9 * t)
    return {
        "angular_velocity.y": rate + 0.02 + 0.01 * a,
        "linear_acceleration.x": -9.81 * math.sin(pitch(t)) + 0.8 * a,
        "linear_acceleration.z": 9.81 * math.cos(pitch(t)) + 0.8 * b,
    }


def _wheels(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"twist.twist.linear.x": 1.03 * speed(t) + 0.2 + 0.05 * a, "twist.covariance[0]": 0.1}


def _gnss_speed(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"twist.twist.linear.x": speed(t - 0.3) + 0.1 * a, "twist.covariance[0]": 0.04}


def _barometer(t: float, a: float, b: float) -> Mapping[str, float]:
    altitude = 300.0 + height(t) + 0.01 * t + 0.05 * a
    return {"fluid_pressure": 101325.0 * (1.0 - altitude / 44330.769) ** 5.25588, "variance": 9.0}


def _range(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"range": height(t) + 0.03 * a, "max_range": 40.0}


def _thermocouple(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"temperature": temperature(t) + 1.5 + 0.005 * t + 0.2 * a}


def _pt100(t: float, a: float, b: float) -> Mapping[str, float]:
    return {"temperature": temperature(t, lag=3.0) + 0.05 * a, "variance": 0.01}


IMU = Sensor("/imu/data", "sensor_msgs/msg/Imu", 100.0, _gyro_z)
TILT = IMU._replace(fields=_tilting)
ODOM = Sensor("/odom", "nav_msgs/msg/Odometry", 50.0, _wheels)
VELOCITY = Sensor("/fix_velocity", "geometry_msgs/msg/TwistWithCovarianceStamped", 1.0, _gnss)
PRESSURE = Sensor("/pressure", "sensor_msgs/msg/FluidPressure", 50.0, _barometer)
RANGE = Sensor("/range", "sensor_msgs/msg/Range", 5.0, _range)
THERMOCOUPLE = Sensor("/thermocouple", "sensor_msgs/msg/Temperature", 20.0, _thermocouple)
ODOMETRY = Sensor("/odom", "nav_msgs/msg/Odometry", 50.0, _odometry)
FIX = Sensor("/odometry/gps", "nav_msgs/msg/Odometry", 5.0, _fix)
PT100 = Sensor("/pt100", "sensor_msgs/msg/Temperature", 1.0, _pt100)

RIGS = {
    "heading": Rig(IMU, VELOCITY, {"": heading}),
    "tilt": Rig(TILT, TILT, {"": pitch}),
    "speed": Rig(ODOM, VELOCITY._replace(fields=_gnss_speed), {"": speed}),
    "altitude": Rig(PRESSURE, RANGE, {"": height}),
    "temperature": Rig(THERMOCOUPLE, PT100, {"": temperature}),
    "three_axes": Rig(ODOMETRY, FIX, POSITION),
}
"""By the names of their presets."""


CHANNELS = [(name, channel) for name, rig in RIGS.items() for channel in rig.truths]
"""Names of presets, and their channels."""


def topics_of(rig: Rig, channel: str) -> Topics:
    """Return where the sensors of a channel are, and its truth."""
    truth = f"point.{'xyz'[list(rig.truths).index(channel)]}"
    return Topics(rig.s1.topic, rig.s2.topic, fields={"truth": truth}, channel=channel)


def write_rig(path: Path, rig: Rig) -> Path:
    """Write what the sensors of a rig publish, and the truth at 20 Hz."""
    truth = Sensor(
        "/truth",
        POINT,
        20.0,
        lambda t, a, b: {
            f"point.{axis}": at(t) for axis, at in zip("xyz", rig.truths.values(), strict=False)
        },
    )
    rng = np.random.default_rng(7)
    rows = []
    for order, sensor in enumerate(dict.fromkeys((truth, rig.s2, rig.s1))):
        paths = list(sensor.fields(0.0, 0.0, 0.0))
        elements = Elements(InstalledTypes(), sensor.type_name, paths)
        codec = ScalarCodec(InstalledTypes(), sensor.type_name, paths[0])
        blank = default_message(InstalledTypes(), sensor.type_name, "base_link")
        for k in range(round(SECONDS * sensor.rate)):
            t = k / sensor.rate
            stamp_ns = BEGIN_NS + round(t * 1e9)
            values = list(sensor.fields(t, *rng.normal(size=2).tolist()).values())
            data = codec.template(elements.written(blank, values)).filled(values[0], stamp_ns)
            rows.append((stamp_ns, order, sensor, data))
    with BagWriter(path) as writer:
        for stamp_ns, _, sensor, data in sorted(rows, key=lambda row: row[:2]):
            writer.write(sensor.topic, sensor.type_name, stamp_ns, data)
    return path
