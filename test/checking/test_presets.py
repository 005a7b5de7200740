# SPDX-License-Identifier: Apache-2.0
"""Which presets suit numbers that move together."""

from __future__ import annotations

import shlex
from collections.abc import Sequence

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.presets import Advice, advise
from fuzzy_fusion_ros.checking.report import advice_json, advice_text
from fuzzy_fusion_ros.checking.survey import Field, survey

TIMES: Reals = 0.02 * np.arange(6000)
COURSE = "atan2(twist.linear.y, twist.linear.x)"


def walk(seed: int) -> Reals:
    """A motion of its own."""
    kernel = np.exp(-np.arange(200) / 40.0)
    return np.convolve(np.random.default_rng(seed).normal(size=6199), kernel, "valid")


def field(topic: str, path: str, unit: str, values: Reals, every: int = 1) -> Field:
    return Field(topic, path, unit, Motion(TIMES[::every], values[::every]))


def imu(turning: float = 1.0) -> list[Field]:
    """A gyro and an accelerometer that have nothing in common."""
    return [
        field("/imu/data", "angular_velocity.x", "rad/s", walk(3)),
        field("/imu/data", "angular_velocity.y", "rad/s", walk(4)),
        field("/imu/data", "angular_velocity.z", "rad/s", turning * walk(1)),
        field("/imu/data", "linear_acceleration.x", "m/s^2", walk(2)),
        field("/imu/data", "pitch(linear_acceleration)", "rad", walk(5)),
        field("/imu/data", "roll(linear_acceleration)", "rad", walk(6)),
    ]


def gnss() -> list[Field]:
    """The integrals of the turn and of the acceleration."""
    course, speed = (np.cumsum(walk(seed)) * 0.02 for seed in (1, 2))
    return [
        field("/fix_velocity", COURSE, "rad", course, 25),
        field("/fix_velocity", "norm(twist.linear)", "m/s", speed, 25),
    ]


def advised(fields: Sequence[Field]) -> list[Advice]:
    return advise(fields, survey(fields))


def test_a_vehicle_with_an_imu_and_a_receiver() -> None:
    found = {each.job.preset: each for each in advised([*imu(), *gnss()])}
    assert found.keys() == {"heading", "speed"}
    assert found["heading"].s1.path == "angular_velocity.z"
    assert found["heading"].s2.path == COURSE
    assert found["heading"].additions == []
    assert found["speed"].s1.path == "linear_acceleration.x"
    assert found["speed"].additions == ["s1.kind: rate"]
    assert shlex.split(found["heading"].options) == [
        *("--s1", "/imu/data", "--s2", "/fix_velocity"),
        *("--field", "s1=angular_velocity.z", "--field", f"s2={COURSE}"),
    ]


def test_a_gyro_that_turns_the_other_way_needs_a_scale() -> None:
    found = {each.job.preset: each for each in advised([*imu(-1.0), *gnss()])}
    assert found["heading"].additions == ["s1.scale: -1.0"]


def test_an_imu_alone_suits_the_tilt_even_if_its_motion_does_not_tell() -> None:
    (found,) = advised(imu())
    assert found.job.preset == "tilt"
    assert (found.s1.path, found.s2.path) == ("angular_velocity.x", "roll(linear_acceleration)")
    assert advice_json(found)["correlation"] is None


def test_numbers_without_a_job_get_no_advice() -> None:
    assert advised([field("/a", "data", "", walk(1)), field("/b", "data", "", walk(1), 5)]) == []


def test_what_is_said_of_a_preset() -> None:
    found = advised([*imu(-1.0), *gnss()])
    text = advice_text(found)
    assert max(map(len, text.splitlines())) <= 80
    assert "heading.yaml with s1.scale: -1.0: correlation " in text
    for each in found:
        assert shlex.join(shlex.split(each.options)) in " ".join(text.replace("\\", "").split())
    document = advice_json(found[0])
    assert document["preset"] == f"{found[0].job.preset}.yaml"
    assert document["correlation"] > 0.9
