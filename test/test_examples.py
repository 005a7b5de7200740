# SPDX-License-Identifier: Apache-2.0
"""The programs in examples/ run as they stand; those that are tests are collected as such."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]


def example(name: str, *arguments: str | Path) -> list[str]:
    """Run a program; return the lines that it prints."""
    done = subprocess.run(
        [sys.executable, ROOT / "examples" / name, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def test_arrays_are_fused() -> None:
    errors = {name: float(rms) for *_, name, rms in map(str.split, example("fuse_arrays.py"))}
    assert list(errors) == ["S1", "held", "estimate"]
    assert errors["estimate"] < 0.25 * min(errors["S1"], errors["held"])


def test_a_bag_is_replayed_scored_and_plotted(tmp_path: Path) -> None:
    plot = tmp_path / "score.png"
    bag = ROOT / "bags" / "nominal"
    said = example("score_bag.py", bag, bag.with_suffix(".yaml"), plot, "10")
    assert said[0] == "5000 estimates written, 4000 scored"
    errors = [float(line.split()[1]) for line in said[1:]]
    assert errors == sorted(errors)
    assert len(errors) == 12
    assert plot.read_bytes().startswith(b"\x89PNG")


def test_every_example_is_listed() -> None:
    page = (ROOT / "examples" / "README.md").read_text()
    for path in (ROOT / "examples").glob("*.py"):
        assert f"| `{path.name}" in page
