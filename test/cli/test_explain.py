# SPDX-License-Identifier: Apache-2.0
"""The command explain."""

from __future__ import annotations

from pathlib import Path

import pytest
from bag.recorded import Scalar, read, swing, write_scalars

from fuzzy_fusion_ros.cli.explain import main
from fuzzy_fusion_ros.cli.replay import main as replay


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag in which S2 falls silent."""
    late = [Scalar("/s1", 5.0 + 0.01 * k, 0.5) for k in range(1000)]
    return write_scalars(tmp_path / "bag", [*swing(), *late])


def test_it_explains_what_a_replay_gives(
    bag: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    params = tmp_path / "params.yaml"
    params.write_text(
        "fusion_node: {ros__parameters: {aggregator: {weight: {very_large: 0.75}}}}\n"
    )
    output = tmp_path / "replayed"
    assert replay([str(bag), "--params", str(params), "--output", str(output)]) == 0
    capsys.readouterr()
    assert main([str(bag), "--at", "1.234", "--params", str(params), "--unit", "rad"]) == 0
    out, said = capsys.readouterr()
    assert said == ""
    estimate = read(output).estimate.values[123]
    assert out.startswith(f"At 1.230 s: The estimate {estimate:.6g} rad is ")
    assert "and 0.03 s old" in out


def test_a_lost_sensor_is_named(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([str(bag), "--at", "14"]) == 0
    out, _ = capsys.readouterr()
    assert out == (
        "At 14.000 s: The estimate 0.5 is S1 alone: S2 has been silent for 9.1 s, longer than "
        "s2.timeout allows. To wait longer for it, raise s2.timeout.\n"
    )


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--at", "20"], "has no message from 20 s on: its last is at 14.990 s"),
        (["--at", "-1"], "argument --at: got '-1', expected a number from 0"),
        ([], "the following arguments are required: --at"),
        (["--at", "1", "--s1", "/s3"], "has no topic '/s3'"),
    ],
)
def test_what_cannot_be_explained_is_an_error(
    bag: Path, arguments: list[str], problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([str(bag), *arguments]) == 2
    assert problem in capsys.readouterr().err


def test_before_both_sensors_have_spoken_there_is_no_estimate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = write_scalars(tmp_path / "bag", [Scalar("/s1", 0.0, 1.0), Scalar("/s2", 1.0, 1.0)])
    assert main([str(bag), "--at", "0.5"]) == 2
    assert "gives no estimate by 0.5 s: S1 or S2 has no sample yet" in capsys.readouterr().err
