# SPDX-License-Identifier: Apache-2.0
"""Measurements side by side: machines are shared and noisy, so only ratios in one run count."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable
from typing import NamedTuple


class Compared(NamedTuple):
    """Ours beside what it is measured against.

    Attributes:
        ours: Median over the repetitions.
        against: Median over the repetitions.
        ratio: Median of the ratios within a repetition, ours by theirs.
    """

    ours: float
    against: float
    ratio: float


def interleaved(repetitions: int, *measure: Callable[[], float]) -> list[list[float]]:
    """Measure in turn, again and again; return a list per measurement, one value per turn."""
    turns = []
    for _ in range(repetitions):
        turn = []
        for each in measure:
            gc.collect()
            turn.append(each())
        turns.append(turn)
    return [list(values) for values in zip(*turns, strict=True)]


def compared(ours: list[float], against: list[float]) -> Compared:
    """Compare values of the same turns."""
    ratios = [one / other for one, other in zip(ours, against, strict=True)]
    return Compared(statistics.median(ours), statistics.median(against), statistics.median(ratios))


def cpu_seconds(work: Callable[[], object]) -> float:
    """Return the CPU time that a call takes in this process, all threads, seconds."""
    begin = time.process_time()
    work()
    return time.process_time() - begin
