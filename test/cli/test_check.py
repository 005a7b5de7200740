# SPDX-License-Identifier: Apache-2.0
"""The command check."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import Scalar, swing, write_scalars
from checking.standins import pair

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.cli.check import main
from fuzzy_fusion_ros.jobs.check import check
from fuzzy_fusion_ros.messages import InstalledTypes, default_message


def write_pair(path: Path, fault: str, s1: str = "/s1", s2: str = "/s2") -> Path:
    """Write made-up sensors as a bag."""
    sensors = pair("four sines", fault, 3)
    scalars = [
        Scalar(topic, float(stamp_s), float(value), float(arrival_s))
        for topic, track in ((s1, sensors.s1), (s2, sensors.s2))
        for stamp_s, arrival_s, value in zip(
            track.stamp_s,
            np.maximum.accumulate(track.arrival_s),  # in order
            track.values,
            strict=True,
        )
    ]
    return write_scalars(path, sorted(scalars, key=lambda each: each.log_s or 0.0))


def test_nothing_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = write_pair(tmp_path / "bag", "none", "/fast", "/slow")
    assert main([str(path), "--s1", "/fast", "--s2", "/slow"]) == 0
    out, said = capsys.readouterr()
    assert said == ""
    assert out.startswith("s1 is /fast point.x\ns2 is /slow point.x\n")
    assert out.endswith("\n\nno problems found\n")


def test_several_bags_are_a_row_each(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bags = [str(write_pair(tmp_path / fault, fault)) for fault in ("none", "negated")]
    document = tmp_path / "found.json"
    given = [*bags, str(tmp_path / "missing"), "--json", str(document), "--jobs", "2"]
    assert main([*given, "--s1", "/s1", "--field", "s1=point.x"]) == 1
    rows = capsys.readouterr().out.splitlines()
    assert rows[1].split()[1:] == ["0"]
    assert "fix: s1.scale: -1" in " ".join(rows)
    assert any("failed: " in row for row in rows)
    found = json.loads(document.read_text())
    assert list(found) == [*bags, str(tmp_path / "missing")]
    assert "error" in found[str(tmp_path / "missing")]


@pytest.mark.parametrize(
    ("fault", "line"),
    [
        ("negated", "s1.scale: -1"),
        ("scale 57.3", "s1.scale: 0.01745329"),
        ("s2 5 s behind", "s2's stamps are 5.0 s behind s1's"),
        ("s1 is the rate", "s1.kind: rate"),
    ],
)
def test_what_is_wrong_is_named_and_gives_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], fault: str, line: str
) -> None:
    path = write_pair(tmp_path / "bag", fault)
    assert main([str(path), "--json", str(tmp_path / "found.json")]) == 1
    out, _ = capsys.readouterr()
    assert line in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80
    document = json.loads((tmp_path / "found.json").read_text())
    assert [each["level"] for each in document["check"]["findings"]] == ["error"]


def test_without_topics_it_lists_what_moves_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_pair(tmp_path / "bag", "none", "/fast", "/slow")
    assert main([str(path)]) == 0
    out, _ = capsys.readouterr()
    assert out.startswith("numbers that move together\n")
    assert "/fast point.x, /slow point.x" in out


def test_topics_that_are_named_are_all_that_is_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where they are the default ones."""
    path = write_pair(tmp_path / "bag", "none")
    assert main([str(path)]) == 0
    assert "numbers that move together" in capsys.readouterr().out
    assert main([str(path), "--s1", "/s1", "--s2", "/s2"]) == 0
    assert "numbers that move together" not in capsys.readouterr().out


def test_several_bags_are_searched_for_the_document_alone(tmp_path: Path) -> None:
    bags = [str(write_pair(tmp_path / name, "none")) for name in "ab"]
    document = tmp_path / "found.json"
    assert main([*bags, "--json", str(document)]) == 0
    assert all(each["together"] for each in json.loads(document.read_text()).values())
    assert check(bags[0], search=False).together is None
    assert check(write_pair(tmp_path / "c", "none", "/fast", "/slow"), search=False).together


def test_sensors_without_a_slash_are_checked_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(write_pair(tmp_path / "bag", "negated", "s1", "s2"))]) == 1
    assert "s1 has the opposite sign of s2" in capsys.readouterr().out


def test_a_problem_of_a_bag_names_the_bag_once(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_pair(tmp_path / "bag", "none")
    (path / "metadata.yaml").unlink()
    assert main([str(path)]) == 0
    problem = "it is missing: the recorder did not close the bag"
    assert capsys.readouterr().err == f"check: {path}: metadata.yaml: {problem}\n"


def test_an_element_beyond_its_array_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    joints = "sensor_msgs/msg/JointState"
    with BagWriter(tmp_path / "bag") as writer:
        data = default_message(InstalledTypes(), joints)
        for k in range(30):
            writer.write("/joints", joints, 10**9 * (k + 1), data)
    sensors = ["--s1", "/joints", "--s2", "/joints"]
    assert main([str(tmp_path / "bag"), *sensors, "--field", "position[7]"]) == 2
    assert "position[7]" in capsys.readouterr().err


def test_a_bag_without_numbers_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with BagWriter(tmp_path / "bag"):
        pass
    assert main([str(tmp_path / "bag")]) == 2
    assert "has no message with a number" in capsys.readouterr().err


def test_json_on_stdout_is_all_that_is_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_pair(tmp_path / "bag", "none")
    assert main([str(path), "--json", "-"]) == 0
    out, said = capsys.readouterr()
    document = json.loads(out)
    assert document["check"]["findings"] == []
    assert document["together"][0]["s1"]["topic"] == "/s1"
    assert "no problems found" in said


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--s2", "/other"], "has no topic '/other'"),
        (["--s1", "/s2", "--field", "/s2=point.w"], "no field 'w'"),
        (["--start", "100"], "no message from 100 s on"),
        (["--json", "/"], "cannot be written"),
    ],
)
def test_what_cannot_be_used_gives_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    path = write_scalars(tmp_path / "bag", swing(2.0))
    assert main([str(path), *arguments]) == 2
    out, said = capsys.readouterr()
    assert out == ""
    assert problem in said
    assert len(said.splitlines()) == 1
