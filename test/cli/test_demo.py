# SPDX-License-Identifier: Apache-2.0
"""The command demo, on canned results."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fuzzy_fusion_ros.cli.demo import main
from fuzzy_fusion_ros.jobs import demo as job
from fuzzy_fusion_ros.jobs.demo import ClosedLoop, DemoResult
from fuzzy_fusion_ros.scoring.score import GIVEN, Score

TIME_S = np.arange(5.0)
SCORE = Score(
    name="bag",
    matched=5,
    of=5,
    every=1,
    span_s=(0.0, 4.0),
    unit="rad",
    recomputed=False,
    baselines=GIVEN,
    time_s=TIME_S,
    truth=TIME_S,
    values={"estimate": TIME_S + 0.1, "s1": TIME_S + 1.0},
    deviations={},
    behind={},
    modes={"FUSED": 1.0},
    notes=(),
)


@pytest.fixture
def differences(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What the demo will find."""
    found: list[str] = []
    loops = [ClosedLoop("estimate", 0.1, 2.0), ClosedLoop("s1", 2.0, 1.5)]
    result = DemoResult(found, SCORE, SCORE._replace(name="pendulum"), loops)
    monkeypatch.setattr(job, "demo", lambda *_, **__: result)
    return found


def test_the_car_comes_first_then_the_pendulum(
    differences: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([]) == 0
    out, said = capsys.readouterr()
    assert said == ""
    car, loops, pendulum, end = out.split("\n\n")
    assert car.startswith("bag\n5 of 5 estimates matched")
    assert car.splitlines()[-2].split()[:2] == ["estimate", "0.1*"]
    assert [line.split() for line in loops.splitlines()[-2:]] == [
        ["estimate", "0.1*", "2"],
        ["s1", "2", "1.5*"],
    ]
    assert "\npendulum\n5 of 5" in pendulum
    assert end.splitlines()[0].startswith("live = replay = simulation, bit for bit")
    assert end.splitlines()[1] == "bags and plots are in out/demo"


def test_a_difference_is_status_1(
    differences: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    differences.append("/estimate differs from message 30 on")
    assert main([]) == 1
    out, said = capsys.readouterr()
    assert said == "demo: not the live run: /estimate differs from message 30 on\n"
    assert "bit for bit" not in out


def test_an_output_that_cannot_be_used_is_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    assert main(["--output", str(tmp_path / "file")]) == 2
    assert "cannot be written" in capsys.readouterr().err
