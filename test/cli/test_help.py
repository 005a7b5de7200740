# SPDX-License-Identifier: Apache-2.0
"""What --help costs and says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
COMMANDS = sorted(
    path.stem
    for path in (ROOT / "fuzzy_fusion_ros" / "cli").glob("*.py")
    if '@command("' in path.read_text()
)
HEAVY = {"matplotlib", "numba", "numpy", "rclpy", "scipy", "tqdm"}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_is_quick_and_fits_a_terminal(command: str) -> None:
    program = f"""
import sys
from fuzzy_fusion_ros.cli.{command} import main
try:
    main(["--help"])
finally:
    print(*sys.modules, file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env={"COLUMNS": "80", "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    assert done.stdout.startswith(f"usage: fuzzy-fusion {command}")
    assert max(map(len, done.stdout.splitlines())) <= 80
    assert HEAVY & set(done.stderr.split()) == set()
