# SPDX-License-Identifier: Apache-2.0
"""How much is run: enough for numbers to report, or just enough to see that it runs."""

from __future__ import annotations

from typing import NamedTuple


class Effort(NamedTuple):
    """The size of a run.

    Attributes:
        repetitions: Interleaved repetitions of each measurement.
        steps: Updates of an estimator per repetition.
        slow_steps: Updates of what takes a thousand times longer.
        seconds: Length of a burst of samples over DDS.
        rates: Rates of samples over DDS, Hz.
        loops: Turns of the closed loop per repetition.
        messages: Messages in the largest bag.
        seeds: Seeds that ``reproduce`` is run with, rising.
        lengths: Lengths of recordings that ``tune`` is run with, rising, seconds.
    """

    repetitions: int
    steps: int
    slow_steps: int
    seconds: float
    rates: tuple[int, ...]
    loops: int
    messages: int
    seeds: tuple[int, ...]
    lengths: tuple[float, ...]


FULL = Effort(
    repetitions=5,
    steps=5000,
    slow_steps=50,
    seconds=2.0,
    rates=(100, 1000),
    loops=2000,
    messages=200_000,
    seeds=(5, 20),
    lengths=(150.0, 600.0),
)

TINY = Effort(
    repetitions=2,
    steps=40,
    slow_steps=2,
    seconds=0.1,
    rates=(100,),
    loops=50,
    messages=400,
    seeds=(2,),
    lengths=(30.0,),
)
