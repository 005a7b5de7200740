# SPDX-License-Identifier: Apache-2.0
"""A process under measurement."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import fuzzy_fusion_ros
from fuzzy_fusion_ros.testing.process import PROGRAM

PACKAGE = Path(fuzzy_fusion_ros.__file__).resolve().parents[1]
TESTS = Path(__file__).resolve().parents[1]


class Child:
    """A child process that runs.

    Attributes:
        pid: Its id.
    """

    def __init__(self, pid: int) -> None:
        self.pid = pid

    @property
    def cpu(self) -> float:
        """CPU time of all threads that live, seconds; the scheduler's own count, exact."""
        total_ns = 0
        for task in Path(f"/proc/{self.pid}/task").iterdir():
            total_ns += int((task / "schedstat").read_text(encoding="ascii").split()[0])
        return total_ns * 1e-9


def program(name: str, *arguments: str) -> list[str]:
    """Return the command that runs an executable of this package."""
    return [sys.executable, "-c", PROGRAM.format(name=name), *arguments]


def module(name: str, *arguments: str) -> list[str]:
    """Return the command that runs a module of this folder."""
    return [sys.executable, "-m", f"bench.{name}", *arguments]


def environment(more: Mapping[str, str]) -> dict[str, str]:
    """Return the environment in which children find this package and this folder."""
    places = (str(PACKAGE), str(TESTS), os.environ.get("PYTHONPATH"))
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, places)), **more}


@contextlib.contextmanager
def running(command: list[str], more: Mapping[str, str]) -> Iterator[Child]:
    """Run a child for as long as the context lasts; it is told to stop at the end."""
    process = subprocess.Popen(
        command,
        env=environment(more),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        yield Child(process.pid)
    finally:
        process.send_signal(signal.SIGTERM)
        try:
            process.wait(5.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
