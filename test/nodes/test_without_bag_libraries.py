# SPDX-License-Identifier: Apache-2.0
"""Nodes where mcap and rosbags are not installed: they run, unless they are to record."""

from __future__ import annotations

import subprocess
import sys

import pytest

PROGRAM = """
import sys
for name in ("lz4", "mcap", "numba", "rosbags", "zstandard"):
    sys.modules[name] = None  # as if it were not installed
from fuzzy_fusion_ros.cli.program import main
sys.exit(main())
"""


def run(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", PROGRAM, *arguments], capture_output=True, text=True, check=False
    )


def test_the_loop_is_closed_without_them() -> None:
    quick = ("--ros-args", "-p", "duration:=0.05", "-p", "feedback:=s1")
    done = run("pendulum_node", *quick)
    assert (done.returncode, "Traceback" in done.stderr) == (0, False)


@pytest.mark.parametrize(
    "arguments",
    [
        ("fusion_node", "--ros-args", "-p", "record:=live"),
        ("replay", "bags/nominal", "--output", "replayed"),
        ("score", "bags/nominal"),
        ("tune", "bags/nominal", "--output", "tuned.yaml"),
    ],
)
def test_what_needs_them_says_so_in_one_line(arguments: tuple[str, ...]) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"{arguments[0]}: ")
    assert " is not installed: in a workspace, run src/fuzzy_fusion_ros/install.sh" in done.stderr
