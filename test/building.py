# SPDX-License-Identifier: Apache-2.0
"""Builds with colcon in a workspace of the test's own, and takes the environment that it makes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "fuzzy_fusion_ros"


def run(
    *command: str | Path, cwd: Path, environment: Mapping[str, str] | None = None
) -> subprocess.CompletedProcess[str]:
    """Run a command to its end; what it says is shown if it fails.

    Args:
        command: The command and its arguments.
        cwd: Where.
        environment: Its environment, if not this process's as :func:`inherited_environment` has it.

    Raises:
        AssertionError: Its exit status is not 0.
    """
    done = subprocess.run(
        [str(word) for word in command],
        cwd=cwd,
        env=inherited_environment() if environment is None else environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command} exited {done.returncode}\n{done.stdout}{done.stderr}"
    return done


def copied(folder: Path) -> Path:
    """Copy what is packaged, so that no build leaves anything in the repository.

    Args:
        folder: Where to.

    Returns:
        The copy.
    """
    copy = folder / PACKAGE
    copy.mkdir()
    for name in ("package.xml", "setup.py", "setup.cfg", "LICENSE", "README.md"):
        if (ROOT / name).exists():
            shutil.copy2(ROOT / name, copy)
    for name in (PACKAGE, "resource", "config", "launch", "bags", "test"):
        if (ROOT / name).exists():
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def inherited_environment() -> dict[str, str]:
    """Return this process's environment, less what would measure the copies' coverage."""
    return {name: value for name, value in os.environ.items() if not name.startswith("COVERAGE_")}


def colcon(verb: str, workspace: Path, *arguments: str | Path) -> str:
    """Run a verb of colcon and return what it prints; its logs go below ``workspace``."""
    command = [sys.executable, "-m", "colcon", "--log-base", str(workspace / "log"), verb]
    return run(*command, *arguments, cwd=workspace).stdout


def spaces(source: Path, workspace: Path) -> tuple[str | Path, ...]:
    """Tell colcon where the source space, the build space and the install space are."""
    build, install = workspace / "build", workspace / "install"
    return ("--paths", source, "--build-base", build, "--install-base", install)


def sourced(workspace: Path) -> dict[str, str]:
    """Return the environment of a shell that has sourced a workspace's setup.bash."""
    setup = workspace / "install" / "setup.bash"
    listing = run("bash", "-c", f'. "{setup}" && env -0', cwd=workspace).stdout
    return dict(entry.split("=", 1) for entry in listing.split("\0") if entry)
