# SPDX-License-Identifier: Apache-2.0
"""reproduce and tune: how long they take, how that grows, and whether both cores work."""

from __future__ import annotations

import os
import statistics
import subprocess
import tempfile
import time
from collections.abc import Sequence

from bench.child import environment, program
from bench.effort import Effort
from bench.machine import ROOT
from bench.table import Aim, Row, at_most

SWEEP, ALL = "18", "6-23"
"""Figures: one of a sweep over a parameter, and all: six sweeps besides single runs."""

BAG = ROOT / "bags" / "car_accel"

TEN_MINUTES = 600.0
LIMIT = at_most(40.0, "s")
"""Wall time of ``tune`` for ten minutes at 100 Hz, on two cores."""


def rows(effort: Effort) -> list[Row]:
    """Measure wall and CPU time of whole processes."""
    with tempfile.TemporaryDirectory() as folder:

        def figures(which: str, seeds: int) -> list[str]:
            return ["--figures", which, "--seeds", str(seeds), "--output", f"{folder}/reproduce"]

        def length(seconds: float) -> list[str]:
            return [str(BAG), "--end", str(seconds), "--output", f"{folder}/tuned.yaml"]

        reproduce = {f"reproduce, one sweep, {n} seeds": figures(SWEEP, n) for n in effort.seeds}
        if len(effort.seeds) > 1:
            fewest = effort.seeds[0]
            reproduce[f"reproduce, all figures, {fewest} seeds"] = figures(ALL, fewest)
        tune = {f"tune, {each:g} s of 100 Hz": length(each) for each in effort.lengths}
        return [
            *_rows("reproduce", reproduce, effort.repetitions),
            *_rows("tune", tune, effort.repetitions, LIMIT),
        ]


def _rows(
    name: str, runs: dict[str, list[str]], repetitions: int, limit: Aim | None = None
) -> list[Row]:
    """Run an executable in several sizes, in turn; a first run that compiles does not count.

    Args:
        name: The executable.
        runs: Its arguments, by what is said of them.
        repetitions: How often each size is run.
        limit: Of the wall time of ten minutes.
    """
    costs: dict[str, list[tuple[float, float]]] = {what: [] for what in runs}
    smallest = next(iter(runs))
    if repetitions > 1:
        _run(name, runs[smallest])
    for _ in range(repetitions):
        for what, arguments in runs.items():
            costs[what].append(_run(name, arguments))
    base = statistics.median(cpu for _, cpu in costs[smallest])
    found = []
    for what, taken in costs.items():
        wall = statistics.median(each[0] for each in taken)
        cpu = statistics.median(each[1] for each in taken)
        cores = statistics.median(each[1] / each[0] for each in taken)
        ours = f"{wall:.1f} s wall, {cpu:.1f} s CPU, {cores:.2f} cores used"
        found.append(Row(what, ours, f"{base:.1f} s CPU, {smallest}", cpu / base))
        if limit and what.startswith(f"{name}, {TEN_MINUTES:g} s"):
            found.append(Row(f"{what}: wall time", f"{wall:.1f} s", "", wall, limit))
    return found


def _run(name: str, arguments: Sequence[str]) -> tuple[float, float]:
    """Return wall and CPU time, seconds."""
    begin = time.monotonic()
    child = subprocess.Popen(
        program(name, *arguments),
        env=environment({}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in {0, 1}:  # 1: a claim does not hold, with so few seeds
        raise RuntimeError(f"{name} {' '.join(arguments)} exited {child.returncode}")
    return time.monotonic() - begin, used.ru_utime + used.ru_stime
