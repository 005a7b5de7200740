# SPDX-License-Identifier: Apache-2.0
"""Two hosts on one machine: network namespaces, joined by a cable that can be cut. Root only."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from faults.waiting import wait_until
from fuzzy_fusion_ros.testing.process import PROGRAM, SOURCES

NAMES = ("a", "b")


class Program:
    """An executable of this package that runs on a host.

    Attributes:
        said: The file with all that it has said.
    """

    def __init__(self, said: Path, child: subprocess.Popen[bytes]) -> None:
        self.said = said
        self._child = child

    def count(self, text: str) -> int:
        """Return how many of the lines that it has said hold a text."""
        return sum(text in line for line in self.said.read_text().splitlines())

    @property
    def status(self) -> int | None:
        """Its exit status; ``None`` while it runs."""
        return self._child.poll()

    def stop(self) -> int:
        """End it in good order and return its exit status."""
        if self.status is None:
            self._child.terminate()
        return self._child.wait(60)

    def close(self) -> None:
        """Kill it if it still runs."""
        if self.status is None:
            self._child.kill()
            self._child.wait()


class Hosts:
    """Hosts ``a`` and ``b`` and the cable between them; a context manager that leaves nothing."""

    def __enter__(self) -> Hosts:
        """Set up both hosts.

        Raises:
            CalledProcessError: That is not allowed here.
        """
        self._names = {each: f"ffr-{os.getpid()}-{each}" for each in NAMES}
        self._programs: list[Program] = []
        with contextlib.ExitStack() as opening:
            self._folder = Path(opening.enter_context(tempfile.TemporaryDirectory()))
            for each in NAMES:
                ip("netns", "add", self._names[each])
                opening.callback(ip, "netns", "del", self._names[each])
            ends = [arg for each in NAMES for arg in ("name", "cable", "netns", self._names[each])]
            ip("link", "add", *ends[:4], "type", "veth", "peer", *ends[4:])
            for k, each in enumerate(NAMES, 1):
                inside = ("-n", self._names[each])
                ip(*inside, "addr", "add", f"10.99.0.{k}/24", "dev", "cable")
                ip(*inside, "link", "set", "lo", "up")
                ip(*inside, "link", "set", "cable", "up")
            # DDS uses only links that are up when it starts; the kernel says so up to 1 s late.
            wait_until(lambda: all(map(is_up, self._names.values())), "the cable is up")
            opening.callback(self._close_programs)
            self._closing = opening.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        """End all programs, remove both hosts."""
        self._closing.close()

    def start(self, host: str, executable: str, *arguments: str) -> Program:
        """Start an executable on a host; it sees the other host, as on any network."""
        said = self._folder / f"{len(self._programs)}"
        python, program = [sys.executable], PROGRAM.format(name=executable)
        with said.open("wb") as file:
            child = subprocess.Popen(
                ["ip", "netns", "exec", self._names[host], *python, "-c", program, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                env={
                    **os.environ,
                    "PYTHONPATH": SOURCES,
                    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
                    "ROS_DOMAIN_ID": "0",  # a network of their own: nobody else is there
                    "ROS_LOG_DIR": str(self._folder / "logs"),
                    # Or they would find each other's shared memory, which no cable goes through.
                    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
                    "RCUTILS_LOGGING_BUFFERED_STREAM": "0",
                },
            )
        self._programs.append(Program(said, child))
        return self._programs[-1]

    def cut(self) -> None:
        """Pull the cable."""
        ip("-n", self._names["a"], "link", "set", "cable", "down")

    def mend(self) -> None:
        """Plug the cable in again."""
        ip("-n", self._names["a"], "link", "set", "cable", "up")

    def _close_programs(self) -> None:
        for each in self._programs:
            each.close()


def is_up(name: str) -> bool:
    """Return whether the end of the cable in a namespace is up."""
    return "state UP" in ip("-n", name, "link", "show", "cable")


def ip(*arguments: str) -> str:
    """Run ``ip`` and return what it prints.

    Raises:
        CalledProcessError: It failed.
    """
    return subprocess.run(["ip", *arguments], check=True, capture_output=True, text=True).stdout
