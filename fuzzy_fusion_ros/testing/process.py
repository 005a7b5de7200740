# SPDX-License-Identifier: Apache-2.0
"""Runs an executable of this package as a child process."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

PROGRAM = "import sys; from fuzzy_fusion_ros.cli.{name} import main; sys.exit(main())"
SOURCES = str(Path(__file__).parents[2])


class Process:
    """A child process; a context manager that kills it on exit.

    Attributes:
        pid: Its id.
    """

    def __init__(self, name: str, *arguments: str, environment: Mapping[str, str]) -> None:
        """Start an executable with the interpreter of this process.

        Args:
            name: The executable, such as ``fusion_node``.
            arguments: Its arguments.
            environment: Variables added to those of this process.
        """
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        self._stdout, self._stderr = folder / "stdout", folder / "stderr"
        path = os.pathsep.join(filter(None, (SOURCES, os.environ.get("PYTHONPATH"))))
        with self._stdout.open("w") as stdout, self._stderr.open("w") as stderr:
            self._child = subprocess.Popen(
                [sys.executable, "-c", PROGRAM.format(name=name), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=stdout,
                stderr=stderr,
                env={**os.environ, **environment, "PYTHONPATH": path},
            )
        self.pid = self._child.pid

    def __enter__(self) -> Process:
        """Return the process itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Kill the process if it is still running."""
        self.close()

    @property
    def status(self) -> int | None:
        """Its exit status, negative if a signal ended it; ``None`` while it is running."""
        return self._child.poll()

    @property
    def stdout(self) -> str:
        """Its output so far."""
        return self._stdout.read_text()

    @property
    def stderr(self) -> str:
        """Its error output so far."""
        return self._stderr.read_text()

    def send(self, number: signal.Signals) -> None:
        """Send it a signal."""
        self._child.send_signal(number)

    def wait(self, timeout: float = 60.0) -> int:
        """Wait for it to end and return its exit status.

        Raises:
            TimeoutError: It is still running after ``timeout`` seconds.
        """
        try:
            return self._child.wait(timeout)
        except subprocess.TimeoutExpired:
            raise TimeoutError(f"still running after {timeout} s; stderr: {self.stderr}") from None

    def close(self) -> None:
        """Kill the process if it is still running, and delete its output."""
        if self.status is None:
            self._child.kill()
            self._child.wait()
        self._folder.cleanup()
