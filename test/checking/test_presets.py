# SPDX-License-Identifier: Apache-2.0
"""Which presets suit numbers that move together."""

from __future__ import annotations

import math
import re
import shlex
import subprocess
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.presets import JOBS, Advice, Job, advise
from fuzzy_fusion_ros.checking.relation import Kind
from fuzzy_fusion_ros.checking.report import advice_json, advice_text
from fuzzy_fusion_ros.checking.survey import Field, survey
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.group import replace

PRESETS = Path(__file__).resolve().parents[2] / "config" / "presets"
SENSORS = ("s1", "s2")

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
    assert found.keys() == {"heading", "speed", "tilt"}
    assert found["heading"].s1.path == "angular_velocity.z"
    assert found["heading"].s2.path == COURSE
    assert found["heading"].additions == []
    assert found["speed"].s1.path == "linear_acceleration.x"
    assert found["speed"].additions == ["s1.kind: rate"]
    assert shlex.split(advice_json(found["heading"])["options"]) == [
        *("--s1", "/imu/data", "--s2", "/fix_velocity"),
        *("--field", "s1=angular_velocity.z", "--field", f"s2={COURSE}"),
    ]


def test_a_gyro_that_turns_the_other_way_needs_a_scale() -> None:
    found = {each.job.preset: each for each in advised([*imu(-1.0), *gnss()])}
    assert found["heading"].additions == ["s1.scale: -1"]


def test_an_imu_alone_suits_the_tilt_even_if_its_motion_does_not_tell() -> None:
    (found,) = advised(imu())
    assert found.job.preset == "tilt"
    assert (found.s1.path, found.s2.path) == ("angular_velocity.x", "roll(linear_acceleration)")
    assert advice_json(found)["correlation"] is None


@pytest.mark.parametrize(
    ("factor", "garbage", "additions"),
    [
        (5.0 * 180.0 / math.pi, 0.0, ["s1.scale: 0.01745329"]),
        (5.0, 0.0, []),
        (5.0, 1e6, []),
    ],
)
def test_a_gyro_faster_than_any_measures_in_degrees(
    factor: float, garbage: float, additions: list[str]
) -> None:
    rates = factor * walk(3) / np.std(walk(3))
    rates[100] += garbage
    gyro = field("/imu/data", "angular_velocity.x", "rad/s", rates)
    (found,) = advised([*(each for each in imu() if each.path != gyro.path), gyro])
    assert (found.job.preset, found.additions) == ("tilt", additions)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_gyro_whose_heading_is_in_degrees_has_its_tilt_in_degrees_too(sign: float) -> None:
    found = {each.job.preset: each for each in advised([*imu(sign * 180.0 / math.pi), *gnss()])}
    assert found["heading"].additions == [f"s1.scale: {sign * 0.01745329}"]
    assert found["tilt"].additions == ["s1.scale: 0.01745329"]


def test_an_imu_whose_motion_shows_its_tilt_gets_one_advice() -> None:
    tilt = field("/imu/data", "pitch(linear_acceleration)", "rad", np.cumsum(walk(4)) * 0.02)
    others = [each for each in imu() if each.path != tilt.path]
    (found,) = advised([*others, tilt])
    assert (found.job.preset, found.s1.path) == ("tilt", "angular_velocity.y")
    assert found.relation is not None


def test_an_imu_inside_another_message_suits_the_tilt() -> None:
    within = [
        each._replace(path=re.sub(r"(angular|linear)_", r"imu.\1_", each.path)) for each in imu()
    ]
    (found,) = advised(within)
    assert found.s1.path == "imu.angular_velocity.x"
    assert found.s2.path == "roll(imu.linear_acceleration)"


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_speed_in_another_unit_needs_its_scale(sign: float) -> None:
    wheels = field("/wheels", "linear.x", "", sign * 3.6 * walk(1))
    (found,) = advised([wheels, field("/vel", "twist.linear.x", "m/s", walk(1), 10)])
    assert found.additions == [f"s1.scale: {sign / 3.6:.7g}"]


@pytest.mark.parametrize(("sign", "presets"), [(1.0, ["temperature"]), (-1.0, [])])
def test_thermometers_that_move_in_opposite_directions_do_not_suit(
    sign: float, presets: list[str]
) -> None:
    found = advised(
        [
            field("/quick", "temperature", "degC", sign * walk(1)),
            field("/probe", "temperature", "degC", walk(1), 25),
        ]
    )
    assert [each.job.preset for each in found] == presets


@pytest.mark.parametrize("job", JOBS, ids=lambda job: f"{job.preset}, {job.kind.name}")
def test_a_job_says_what_its_preset_says(job: Job) -> None:
    s1, s2 = (getattr(parameters_from(PRESETS / f"{job.preset}.yaml"), each) for each in SENSORS)
    assert re.search(job.s2, s2.field)
    is_rate = job.kind is Kind.S1_RATE
    assert job.sets_kind == ((s1.kind == "rate") == is_rate)
    assert bool(re.search(job.s1, s1.field)) == job.sets_kind


def test_every_preset_of_one_channel_has_a_job() -> None:
    presets = {
        path.stem for path in PRESETS.glob("*.yaml") if "channels:" not in path.read_text("utf-8")
    }
    assert presets == {job.preset for job in JOBS}


def test_numbers_without_a_job_get_no_advice() -> None:
    assert advised([field("/a", "data", "", walk(1)), field("/b", "data", "", walk(1), 5)]) == []


def test_the_commands_make_the_file_that_they_tune(tmp_path: Path) -> None:
    text = advice_text(advised([*imu(-180.0 / math.pi), *gnss()]), "BAG", PRESETS)
    copies = re.findall(r"^  \(cat [^)]*\) > my_\w+\.yaml$", text, re.MULTILINE)
    subprocess.run(["sh", "-c", "\n".join(copies)], cwd=tmp_path, check=True)
    made = {each.name: parameters_from(each) for each in tmp_path.iterdir()}
    added = {
        "heading": {"s1.scale": -0.01745329},
        "speed": {"s1.kind": "rate"},
        "tilt": {"s1.scale": 0.01745329},
    }
    assert made == {
        f"my_{name}.yaml": replace(parameters_from(PRESETS / f"{name}.yaml"), each)
        for name, each in added.items()
    }


def test_what_is_said_of_a_preset() -> None:
    found = advised([*imu(-1.0), *gnss()])
    text = advice_text(found, "my drive", Path("config/presets"))
    assert "fuzzy-fusion tune 'my drive' \\\n" in text
    assert max(map(len, text.splitlines())) <= 80
    assert "heading.yaml with s1.scale: -1: correlation " in text
    for each in found:
        assert advice_json(each)["options"] in " ".join(text.replace("\\", "").split())
        file = f"{each.job.preset}.yaml"
        file = f"my_{file}" if each.additions else f"config/presets/{file}"
        assert f"  --params {file} --s1 " in text
    document = advice_json(found[0])
    assert document["preset"] == f"{found[0].job.preset}.yaml"
    assert document["correlation"] > 0.9
