# SPDX-License-Identifier: Apache-2.0
"""A disk that fills up under each executable that writes bags."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.testing import Harness

ROOT = Path(__file__).resolve().parents[2]

# The limit ends with the executable, so that coverage can write its own file after it.
LIMITED = """
import resource, sys
_, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, hard))
from fuzzy_fusion_ros.cli.{name} import main
try:
    sys.exit(main())
finally:
    resource.setrlimit(resource.RLIMIT_FSIZE, (hard, hard))
"""
UNLIMITED = "import sys; from fuzzy_fusion_ros.cli.{name} import main; sys.exit(main())"
LIMIT = 100_000


def run(program: str, name: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run an executable to its end."""
    with Harness() as harness:
        return subprocess.run(
            [sys.executable, "-c", program.format(limit=LIMIT, name=name), *arguments],
            cwd=ROOT,
            env={**os.environ, **harness.environment},
            capture_output=True,
            text=True,
            check=False,
        )


def check(done: subprocess.CompletedProcess[str], path: Path, why: str) -> None:
    """Check that a run ended in good order on a full disk, and left what it had written."""
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert f"cannot be written: {why}; what was written before stays readable" in done.stderr
    with open_bag(path) as bag:
        found = list(bag.messages())
        assert len(found) > 500
        assert not any("are lost" in each for each in bag.problems)


@contextlib.contextmanager
def small_disk(path: Path) -> Iterator[Path]:
    """Mount a file system of 128 KiB; root only."""
    path.mkdir()
    subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "none", path], check=True)
    try:
        yield path
    finally:
        subprocess.run(["umount", path], check=True)


def test_replay_on_a_file_that_may_grow_no_more(tmp_path: Path) -> None:
    path = tmp_path / "out"
    done = run(LIMITED, "replay", str(ROOT / "bags/nominal"), "--output", str(path))
    check(done, path, "File too large")


def test_a_recording_node_on_a_file_that_may_grow_no_more(tmp_path: Path) -> None:
    path = tmp_path / "out"
    settings = ("feedback:=truth", f"record:={path}")
    arguments = ["--ros-args", *(word for each in settings for word in ("-p", each))]
    check(run(LIMITED, "pendulum_node", *arguments), path, "File too large")


@pytest.mark.skipif(
    os.geteuid() != 0 or shutil.which("mount") is None, reason="only root can mount a small disk"
)
def test_replay_on_a_disk_that_is_full(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as disk:
        path = disk / "out"
        done = run(UNLIMITED, "replay", str(ROOT / "bags/nominal"), "--output", str(path))
        check(done, path, "No space left on device")
