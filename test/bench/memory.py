# SPDX-License-Identifier: Apache-2.0
"""Memory of an offline replay over the length of the bag."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from bench.big_bag import RECORDING, write_bag
from bench.child import environment, module
from bench.effort import Effort
from bench.table import Row, at_most

LIMIT = at_most(200.0, "MB")
LONGEST = 10_000_000
"""Messages for which the limit is meant."""

ENOUGH = 100_000
"""Messages from which on growth of memory stands out from its noise."""


def rows(effort: Effort) -> list[Row]:
    """Measure the peak of three lengths; carry it on to ``LONGEST`` if they do not reach it."""
    sizes = [effort.messages // 4, effort.messages // 2, effort.messages]
    with tempfile.TemporaryDirectory() as folder:
        peaks = [_peak_mb(Path(folder), size) for size in sizes]
    measured = [
        Row(f"replay's peak memory, {size:,} messages", f"{peak:.0f} MB", "", peak, LIMIT)
        for size, peak in zip(sizes, peaks, strict=True)
    ]
    if not ENOUGH <= sizes[-1] < LONGEST:
        return measured
    slope = (peaks[-1] - peaks[0]) / (sizes[-1] - sizes[0])
    projected = peaks[-1] + slope * (LONGEST - sizes[-1])
    what = f"replay's peak memory, carried on to {LONGEST:,} messages"
    against = f"{slope * 1e6:.1f} MB more per million"
    return [*measured, Row(what, f"{projected:.0f} MB", against, projected, LIMIT)]


def _peak_mb(folder: Path, messages: int) -> float:
    """Replay a bag in a process of its own; return the most memory that it had, MB."""
    path, output = folder / "bag", folder / "out"
    write_bag(path, messages, RECORDING)
    done = subprocess.run(
        module("replay_once", str(path), str(output)),
        env=environment({}),
        capture_output=True,
        text=True,
        check=True,
    )
    shutil.rmtree(path)
    shutil.rmtree(output)
    return int(done.stdout) / 1024.0
