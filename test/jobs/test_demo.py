# SPDX-License-Identifier: Apache-2.0
"""The job of make demo: once as a whole, and its parts on a short run."""

from __future__ import annotations

import os
import shutil
import site
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag.recorded import messages

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.jobs import demo as module
from fuzzy_fusion_ros.jobs import shared
from fuzzy_fusion_ros.jobs.demo import DemoError, demo, real_bags, run_live
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.scoring.score import Score
from fuzzy_fusion_ros.text.table import WIDTH

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.xdist_group("demo")


def test_the_whole_job(tmp_path: Path) -> None:
    out = tmp_path / "out" / "demo"
    shutil.copytree(ROOT / "bags" / "nominal", out / "live")  # as an earlier demo leaves it
    done = subprocess.run(
        [sys.executable, "-c", "from fuzzy_fusion_ros.cli.demo import main; exit(main())"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert max(map(len, done.stdout.splitlines())) <= WIDTH
    car, loops, pendulum, end = done.stdout.split("\n\n")
    assert "car_accel\n30000 of 30000 estimates matched" in car
    assert "pendulum\n5000 of 5000 estimates matched" in pendulum
    for table in (car, pendulum):
        assert "baselines: as tune has fitted them" in " ".join(table.split())
        assert [row.split()[0] for row in table.splitlines()[-12:]][:3] == ["estimate", "s1", "s2"]
    rows = {name: values for name, *values in map(str.split, loops.splitlines()[-4:])}
    assert list(rows) == ["estimate", "s1", "s2", "average"]
    assert [name for name, values in rows.items() if "*" in "".join(values)] == ["estimate"]
    assert end.startswith("live = replay = simulation, bit for bit")
    assert sorted(path.name for path in out.iterdir()) == [
        "car_accel.png",
        "live",
        "live_fusion",
        "pendulum.png",
        "replayed",
    ]


@pytest.fixture(scope="module")
def live(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short live run with seed 1."""
    folder = tmp_path_factory.mktemp("live")
    run_live(folder, 1, 0.5)
    return folder


@pytest.fixture
def quick(
    live: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Let the live run be the recorded one, the drive no longer than it, and nothing be drawn."""

    def copy(output: Path, *_: object) -> None:
        shutil.copytree(live, output, dirs_exist_ok=True)

    def score(bag: Path, **options: Any) -> Score:
        return whole(live / "live", **{**options, "start": None, "fit_baselines": False})

    whole: Callable[..., Score] = module.score
    monkeypatch.setattr(module, "run_live", copy)
    monkeypatch.setattr(module, "score", score)
    monkeypatch.setattr(module, "_plot", lambda *_: None)


@pytest.mark.slow("two more live runs")
def test_the_seed_decides(live: Path, tmp_path: Path) -> None:
    for name, seed in (("same", 1), ("other", 2)):
        (tmp_path / name).mkdir()
        run_live(tmp_path / name, seed, 0.5)
    first = messages(live / "live", ["/s1"])
    assert len(first) == 50
    assert messages(tmp_path / "same" / "live", ["/s1"]) == first
    assert messages(tmp_path / "other" / "live", ["/s1"]) != first


@pytest.mark.usefixtures("quick")
def test_a_short_run_is_replayed_and_simulated_bit_for_bit(tmp_path: Path) -> None:
    found = demo(tmp_path / "out", seed=1, seconds=0.5)
    assert found.differences == []
    assert [each.signal for each in found.loops] == ["estimate", "s1", "s2", "average"]
    angle = np.abs(found.pendulum.truth)
    assert found.loops[0].iae == pytest.approx(0.01 * np.sum(angle))
    assert found.loops[0].itae == pytest.approx(0.01 * np.sum(angle * np.arange(50) * 0.01))


@pytest.mark.usefixtures("quick")
def test_differences_are_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole: Callable[..., Any] = module.replay
    monkeypatch.setattr(module, "replay", lambda *a, **kw: whole(*a, **{**kw, "end": 0.3}))
    found = demo(tmp_path / "out", seed=1, seconds=0.5)
    assert "/estimate differs from message 30 on" in found.differences
    assert "/truth differs from the simulation in this process" in found.differences


def test_what_is_not_a_bag_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "live").mkdir()
    (tmp_path / "live" / "thesis.tex").touch()
    with pytest.raises(DemoError, match="is not a bag: remove it, or choose another --output"):
        demo(tmp_path)
    assert (tmp_path / "live" / "thesis.tex").exists()


@pytest.mark.slow("two live runs that fail")
def test_a_node_that_fails_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DemoError, match=r"pendulum_node has failed: pendulum_node: .*duration"):
        run_live(tmp_path, 0, -1.0)
    monkeypatch.setattr(module, "PARAMETERS", {"trigger": "never", "qos": "reliable"})
    with pytest.raises(DemoError, match=r"fusion_node has exited: .*never"):
        run_live(tmp_path, 0, 0.1)


@pytest.mark.slow("another live run")
def test_a_run_that_takes_too_long_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LONGEST", 0.0)
    with pytest.raises(DemoError, match="the live run did not end within 0 s"):
        run_live(tmp_path, 0, 50.0)


def test_the_output_must_be_writable(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(FusionError, match="cannot be written"):
        demo(tmp_path / "file")


def test_the_recordings_are_beside_the_sources_or_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert real_bags() == ROOT / "bags"
    monkeypatch.setattr(shared, "__file__", str(tmp_path / "a" / "b" / "shared.py"))
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "python"))
    monkeypatch.setattr(sysconfig, "get_path", {"data": str(tmp_path / "local")}.__getitem__)
    monkeypatch.setattr(site, "getuserbase", lambda: str(tmp_path / "user"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'none'}:{tmp_path / 'prefix'}")
    with pytest.raises(DemoError, match=r"bag 'car_accel' was not found in .*prefix/share"):
        real_bags()
    installed = tmp_path / "prefix" / "share" / "fuzzy_fusion_ros" / "bags"
    (installed / "car_accel").mkdir(parents=True)
    assert real_bags() == installed


def test_the_length_of_a_growing_recording(tmp_path: Path) -> None:
    recorded: Callable[[Path], int] = module._recorded
    assert recorded(tmp_path / "none") == 0
    with BagWriter(tmp_path / "bag") as writer:
        assert recorded(tmp_path / "bag") == 0
        for k in range(50):
            writer.write("/x", "std_msgs/msg/Float64", 10**9 + k * 10**8, b"\0\1\0\0" + bytes(8))
        assert 1 <= recorded(tmp_path / "bag") <= 5
    assert recorded(tmp_path / "bag") == 5
