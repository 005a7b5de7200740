# SPDX-License-Identifier: Apache-2.0
"""What replay, score and tune say of the sensors and the truth of a bag, in the words of check."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest
from bag.making import FLOAT, float_data
from bag.recorded import Scalar, at, message, swing, write_scalars
from tuning.quick import be_quick

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.cli import replay, score, tune

SAID = "s1 has the opposite sign of s2 (correlation -"
COMMANDS: dict[str, tuple[Callable[[Sequence[str]], int], list[str]]] = {
    "replay": (replay.main, ["--output", "new"]),
    "score": (score.main, []),
    "tune": (tune.main, ["--output", "new.yaml"]),
}
AS_REPLAY = pytest.mark.slow("by the same function as replay")


@pytest.fixture(autouse=True)
def quickly_in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is written goes to the test's folder; fits take little time."""
    be_quick(monkeypatch)
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize(
    ("command", "sign"),
    [
        ("replay", 1.0),
        ("replay", -1.0),
        ("score", -1.0),
        ("tune", -1.0),
        pytest.param("score", 1.0, marks=AS_REPLAY),
        pytest.param("tune", 1.0, marks=AS_REPLAY),
    ],
)
def test_a_negated_sensor_is_named(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: str,
    sign: float,
) -> None:
    scalars = wavy({"/s1": sign})
    path = write_scalars(tmp_path / "bag", scalars)
    main, options = COMMANDS[command]
    assert main([str(path), *options]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "WARN" in line]
    assert len(said) == (sign < 0.0)
    assert all(SAID in line and line.endswith("; fix: s1.scale: -1") for line in said)


@pytest.mark.parametrize("command", ["score", "tune"])
def test_a_negated_truth_is_named(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    scalars = wavy({"/truth": -1.0})
    path = write_scalars(tmp_path / "bag", scalars)
    main, options = COMMANDS[command]
    assert main([str(path), *options]) == 0
    printed = capsys.readouterr()
    (said,) = (line for line in printed.err.splitlines() if "WARN" in line)
    assert "WARN s1 and s2 agree, but the truth has the opposite sign of s2 (correlation -" in said
    advice = re.findall("WARNING: (.*?)[,:]", printed.out)
    assert advice == ["a truth does not suit the sensors"] * (command == "tune")


@pytest.mark.parametrize("command", ["score", "tune"])
def test_a_negated_s2_is_named_by_the_truth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    path = write_scalars(tmp_path / "bag", wavy({"/s2": -1.0}))
    main, options = COMMANDS[command]
    assert main([str(path), *options]) == 0
    printed = capsys.readouterr()
    (said,) = (line for line in printed.err.splitlines() if "WARN" in line)
    assert "WARN s1 and the truth agree, but s2 has the opposite sign of the truth (" in said
    assert said.endswith("; fix: s2.scale: -1")
    assert "does not suit" not in printed.out


@pytest.mark.parametrize(
    "command", ["replay", *(pytest.param(each, marks=AS_REPLAY) for each in ("score", "tune"))]
)
def test_messages_without_a_timestamp_are_named(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: str,
) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for each in swing(5.0, estimate=False):
            msgtype, data = (
                (FLOAT, float_data(each.value)) if each.topic == "/s2" else message(each)[1::2]
            )
            writer.write(each.topic, msgtype, at(each.time_s), data)
    main, options = COMMANDS[command]
    assert main(["bag", *options, "--field", "/s2=data"]) == 0
    said = [line for line in capsys.readouterr().err.splitlines() if "no timestamp" in line]
    assert [line.partition("/s2: ")[2] for line in said] == [
        "std_msgs/msg/Float64 has no timestamp; using the log time, so transport delay will look "
        "like motion"
    ]


def wavy(signs: Mapping[str, float]) -> list[Scalar]:
    """A swing that comes back several times, with some topics' values times a sign."""
    return [
        each._replace(
            time_s=each.time_s + 5.0 * k,
            value=signs.get(each.topic, 1.0) * each.value * (1.0 + 0.3 * k * k % 1.7),
        )
        for k in range(6)
        for each in swing(5.0)
    ]


def test_values_whose_squares_overflow_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The estimate stays finite, and is of no use: score refuses to score it."""
    huge = [Scalar("/s1", 4.0 + 0.01 * k, 1e200) for k in range(3)]
    write_scalars(tmp_path / "bag", [*swing(4.0, estimate=False), *huge])
    main, options = COMMANDS["replay"]
    assert main(["bag", *options]) == 0
    (said,) = (line for line in capsys.readouterr().err.splitlines() if "WARN" in line)
    assert said.endswith(
        "s1 has values up to 1e+200, whose squares overflow (samples 3); fix: choose another topic "
        "or field"
    )
