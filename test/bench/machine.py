# SPDX-License-Identifier: Apache-2.0
"""Where and of what a benchmark was run."""

from __future__ import annotations

import datetime
import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

from fuzzy_fusion_ros.core.estimator import update

ROOT = Path(__file__).resolve().parents[2]

PACKAGES = ("numpy", "numba", "rosbags", "filterpy", "simpful", "scikit-fuzzy", "ros-jazzy-rclpy")


def described() -> str:
    """Return machine, versions, date, commit and what else keeps the machine busy, in one line."""
    date = datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M UTC")
    versions = ", ".join(f"{name} {_version(name)}" for name in PACKAGES)
    return (
        f"{_processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} before the run; "
        f"Linux {platform.release()}, Python {platform.python_version()}, {versions}; "
        f"the method {_built()}; {date}; commit {_commit()}"
    )


def _processor() -> str:
    lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    names = [each.partition(":")[2].strip() for each in lines if each.startswith("model name")]
    return names[0] if names else platform.machine()


def _built() -> str:
    return "interpreted" if hasattr(update, "__code__") else "compiled ahead of time"


def _version(package: str) -> str:
    try:
        return version(package)
    except ModuleNotFoundError:
        return "none"


def _commit() -> str:
    command = ["git", "describe", "--always", "--dirty", "--abbrev=10"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"
