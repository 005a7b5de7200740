"""The job of make demo."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from bag.recorded import messages

from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.cli import demo as demo_module
from fuzzy_fusion_ros.cli.demo import DemoError, demo, main, real_bag
from fuzzy_fusion_ros.offline import replay as replaying
from fuzzy_fusion_ros.parameters.errors import FusionError

ROOT = Path(__file__).resolve().parents[1]


def test_the_whole_job(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", "from fuzzy_fusion_ros.cli.demo import main; exit(main())"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=280,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    pendulum, car, end = done.stdout.split("\n\n")
    assert pendulum.startswith("pendulum: matched 5000 of 5000 estimates")
    assert car.startswith("car_accel: matched")
    for table in (pendulum, car):
        assert table.splitlines()[3].startswith("estimate ")
        assert table.splitlines()[0].endswith("baselines: as tune has fitted them")
        assert "kalman_bias " in table
    assert end.startswith("live = replay, bit for bit")
    out = tmp_path / "out" / "demo"
    assert sorted(path.name for path in out.iterdir()) == [
        "car_accel.png",
        "live",
        "live_fusion",
        "pendulum.png",
        "replayed",
    ]


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make the run a short one."""
    monkeypatch.setattr(demo_module, "SECONDS", 0.5)


@pytest.mark.usefixtures("short")
def test_the_seed_decides_and_an_earlier_demo_is_replaced(tmp_path: Path) -> None:
    seen = []
    for seed in ("1", "1", "2"):
        assert main(["--output", str(tmp_path / "out"), "--seed", seed]) == 0
        seen.append(messages(tmp_path / "out" / "live", ["/s1"]))
    assert len(seen[0]) == 50
    assert seen[0] == seen[1] != seen[2]


@pytest.mark.usefixtures("short")
def test_a_replay_that_differs_is_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = replaying.replay

    def changed(*arguments: object, **options: object) -> object:
        return whole(*arguments, **{**options, "end_s": 0.3})  # type: ignore[arg-type]

    monkeypatch.setattr(demo_module, "replay", changed)
    assert main(["--output", str(tmp_path / "out")]) == 1
    said = capsys.readouterr()
    assert "demo: the replay is not the live run: /estimate differs from message 30 on" in said.err
    assert "bit for bit" not in said.out


def test_what_is_no_bag_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "live").mkdir()
    (tmp_path / "live" / "thesis.tex").touch()
    with pytest.raises(DemoError, match="is no bag of a demo: remove it"):
        demo(tmp_path, 0, 0.1)
    assert (tmp_path / "live" / "thesis.tex").exists()


def test_a_node_that_fails_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(DemoError, match=r"pendulum_node has failed: pendulum_node: .*duration"):
        demo(tmp_path, 0, -1.0)
    monkeypatch.setattr(demo_module, "PARAMETERS", {"trigger": "never", "qos": "reliable"})
    with pytest.raises(FusionError, match=r"trigger: got 'never'|fusion_node has ended: .*never"):
        demo(tmp_path, 0, 0.1)


def test_a_run_that_takes_too_long_is_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(demo_module, "LONGEST", 0.0)
    with pytest.raises(DemoError, match="the live run is not over after 0 s"):
        demo(tmp_path, 0, 50.0)


def test_the_output_must_be_writable(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert main(["--output", str(tmp_path / "file")]) == 2


def test_the_real_bag_is_beside_the_sources_or_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert real_bag() == ROOT / "bags" / "car_accel"
    monkeypatch.setattr(demo_module, "__file__", str(tmp_path / "a" / "b" / "demo.py"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'none'}:{tmp_path / 'prefix'}")
    with pytest.raises(DemoError, match=r"bag 'car_accel' is in none of .*prefix/share"):
        real_bag()
    installed = tmp_path / "prefix" / "share" / "fuzzy_fusion_ros" / "bags" / "car_accel"
    installed.mkdir(parents=True)
    assert real_bag() == installed


def test_a_growing_recording_tells_how_far_it_is(tmp_path: Path) -> None:
    recorded: Callable[[Path], int] = demo_module._recorded
    assert recorded(tmp_path / "none") == 0
    with BagWriter(tmp_path / "bag") as writer:
        assert recorded(tmp_path / "bag") == 0
        for k in range(50):
            writer.write("/x", "std_msgs/msg/Float64", 10**9 + k * 10**8, b"\0\1\0\0" + bytes(8))
        assert 1 <= recorded(tmp_path / "bag") <= 5
    assert recorded(tmp_path / "bag") == 5
