# SPDX-License-Identifier: Apache-2.0
"""Parameters of several channels: shared defaults, and what each has of its own."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from fuzzy_fusion_ros.parameters.errors import CombinationError, ParameterError
from fuzzy_fusion_ros.parameters.file import dump, parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import described, flatten, replace

AXES = replace(
    Parameters(),
    {
        "channels": ["roll", "pitch"],
        "s1.kind": "rate",
        "s1.field": "angular_velocity.x",
        "pitch.s1.field": "angular_velocity.y",
        "pitch.gate.tolerance": 0.5,
    },
)


def test_a_channel_has_its_own_values_and_those_that_are_shared() -> None:
    roll, pitch = AXES.by_channel().values()
    assert roll == replace(Parameters(), {"s1.kind": "rate", "s1.field": "angular_velocity.x"})
    own = {"s1.field": "angular_velocity.y", "gate.tolerance": 0.5}
    assert pitch == replace(roll, own)


def test_without_channels_there_is_one_without_a_name() -> None:
    assert Parameters().by_channel() == {"": Parameters()}
    assert Parameters().channel("") == Parameters()
    assert described(Parameters()).keys() == flatten(Parameters()).keys()


def test_every_parameter_of_every_channel_has_a_name() -> None:
    flat = flatten(AXES)
    assert described(AXES).keys() == flat.keys()
    assert flat["roll.gate.tolerance"] == Parameters().gate.tolerance
    assert flat["pitch.gate.tolerance"] == 0.5
    assert "roll.trigger" not in flat


def test_a_shared_value_changes_where_none_is_set() -> None:
    changed = replace(AXES, {"gate.tolerance": 0.25})
    assert [each.gate.tolerance for each in changed.by_channel().values()] == [0.25, 0.5]


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"channels": ["a-b"]}, "channels: got 'a-b', expected letters, digits"),
        ({"channels": ["_a"]}, "got '_a', expected"),
        ({"channels": ["a__b"]}, "got 'a__b', expected"),
        ({"channels": [""]}, "got '', expected"),
        ({"channels": ["s1"]}, "'s1' is a parameter: use another name"),
        ({"channels": ["use_sim_time"]}, "'use_sim_time' is a parameter: use another name"),
        ({"channels": ["qos_overrides"]}, "'qos_overrides' is a parameter: use another name"),
        ({"channels": ["start_type_description_service"]}, "service' is a parameter: use another"),
        ({"channels": ["own"]}, "'own' is a parameter: use another name"),
        ({"channels": ["a", "a"]}, "'a' is listed twice: use each name once"),
        ({"channels": "roll"}, "got 'roll', expected a list of strings"),
        ({"channels": [1]}, r"got \(1,\), expected a list of strings"),
        ({"roll.trigger": "pair"}, "roll.trigger: unknown; known below roll: s1.type, "),
        ({"roll.gate.tolerance": -1.0}, "roll.gate.tolerance: got -1.0, expected a number from 0"),
        ({"yaw.gate.tolerance": 1.0}, "yaw.gate.tolerance: unknown"),
    ],
)
def test_what_cannot_be_used_is_refused(changes: dict[str, object], problem: str) -> None:
    with pytest.raises(ParameterError, match=problem):
        replace(AXES, changes)


def test_a_channels_values_have_to_go_together() -> None:
    with pytest.raises(CombinationError, match=r"roll\.aggregator\.rate\.small: got 7"):
        replace(AXES, {"roll.aggregator.rate.small": 7.0})
    with pytest.raises(CombinationError, match=r"pitch\.aggregator\.rate\.small: got 1"):
        replace(
            replace(AXES, {"pitch.aggregator.rate.small": 1.0}),
            {"aggregator.rate.small": 0.0, "aggregator.rate.large": 0.5},
        )


@pytest.mark.parametrize(
    ("parameters", "name", "problem"),
    [
        (AXES, "", r"there are several channels \(roll, pitch\): choose one with --channel"),
        (AXES, "yaw", "channels: there is no 'yaw', only roll, pitch"),
        (Parameters(), "yaw", "channels: is empty, so there is no channel 'yaw'"),
    ],
)
def test_a_channel_that_is_not_there_is_named(
    parameters: Parameters, name: str, problem: str
) -> None:
    with pytest.raises(ParameterError, match=problem):
        parameters.channel(name)


def test_one_channel_can_be_replaced() -> None:
    tuned = replace(AXES.channel("roll"), {"gate.tolerance": 0.125})
    changed = AXES.with_channel("roll", tuned)
    assert changed.channel("roll") == tuned
    assert changed.channel("pitch") == AXES.channel("pitch")
    assert changed.gate == AXES.gate
    assert Parameters().with_channel("", tuned) == tuned


def test_one_channel_can_be_taken_alone() -> None:
    assert AXES.only("pitch").by_channel() == {"pitch": AXES.channel("pitch")}
    assert AXES.only("") == AXES


def test_they_are_written_and_read_back(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    dump(AXES, path)
    assert parameters_from(path) == AXES
    assert pickle.loads(pickle.dumps(AXES)) == AXES
    own = path.read_text(encoding="utf-8").partition("    pitch:\n")[2]
    assert own.count("field:") == own.count("tolerance:") == 1
    assert "type:" not in own


@pytest.mark.parametrize(
    ("channels", "problem"),
    [
        ("", "there is no channel 'rol' in channels, which has: none; add it there"),
        ("channels: []", "there is no channel .rol. in channels, which has: none"),
        ("channels: [roll, pitch]", ".*which has: roll, pitch; add it there, or use one of these"),
    ],
)
def test_a_channel_of_a_file_that_is_not_listed_is_named(
    tmp_path: Path, channels: str, problem: str
) -> None:
    path = tmp_path / "p.yaml"
    lines = ["/**:", "  ros__parameters:", f"    {channels}", "    rol.s1.field: data"]
    path.write_text("\n".join(lines), encoding="utf-8")
    with pytest.raises(ParameterError, match=f"rol.s1.field: {problem}"):
        parameters_from(path)
