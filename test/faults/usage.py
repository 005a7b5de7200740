# SPDX-License-Identifier: Apache-2.0
"""What a process holds: memory and file descriptors, from /proc."""

from __future__ import annotations

import os
from pathlib import Path
from typing import NamedTuple

MIB = 1024.0 * 1024.0


class Usage(NamedTuple):
    """What a process holds now.

    Attributes:
        memory: Resident memory, MiB.
        descriptors: Open file descriptors.
    """

    memory: float
    descriptors: int


def usage(pid: int) -> Usage:
    """Return what a process holds."""
    pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    descriptors = len(os.listdir(f"/proc/{pid}/fd"))
    return Usage(pages * os.sysconf("SC_PAGESIZE") / MIB, descriptors)


class Watch:
    """Watches a process after its start-up; the rest of its life is compared with that.

    Attributes:
        looks: What it held at each look.
    """

    def __init__(self, pid: int) -> None:
        self._pid = pid
        self.looks: list[Usage] = []

    def look(self) -> None:
        """Look once."""
        self.looks.append(usage(self._pid))

    @property
    def growth(self) -> float:
        """By how much memory has grown since the first look, at most, MiB."""
        return max(each.memory for each in self.looks) - self.looks[0].memory

    @property
    def late_growth(self) -> float:
        """By how much it has grown in the second half, MiB: about 0 where nothing leaks."""
        half = self.looks[len(self.looks) // 2 :]
        return max(each.memory for each in half) - half[0].memory

    @property
    def more_descriptors(self) -> int:
        """How many more descriptors there were than at the first look, at most."""
        return max(each.descriptors for each in self.looks) - self.looks[0].descriptors
