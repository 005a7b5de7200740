# SPDX-License-Identifier: Apache-2.0
"""Streams of samples as they arrive: what faults are injected into."""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.sample import Sample

S1, S2 = "s1", "s2"
SECOND_NS = 1_000_000_000
START_NS = 10_000 * SECOND_NS
"""Late enough that a clock can be turned back by an hour."""

STEP_NS = 10_000_000
"""Time between two samples of S1: 100 Hz."""


class Arrival(NamedTuple):
    """A sample that reaches the fusion.

    Attributes:
        sensor: S1 or S2.
        sample: The sample, whatever it holds.
        now_ns: Time of receipt on the clock of the stamps, nanoseconds, never falling.
    """

    sensor: str
    sample: Sample
    now_ns: int


Stream = list[Arrival]


def clean_stream(samples: int, every: int = 1, first: int = 0) -> Stream:
    """Return a swing as both sensors see it: S2 without error, S1 off by up to 0.05.

    Args:
        samples: Samples of S1.
        every: A sample of S2 comes before each so-manieth of S1, with its stamp.
        first: Number of the first sample; a stream can be made in pieces.
    """
    stream: Stream = []
    for k in range(first, first + samples):
        stamp_ns = START_NS + k * STEP_NS
        if k % every == 0:
            stream.append(Arrival(S2, Sample(stamp_ns, signal(k)), stamp_ns))
        error = 0.05 * math.sin(2.1 * k)
        stream.append(Arrival(S1, Sample(stamp_ns, signal(k) + error), stamp_ns))
    return stream


def signal(k: int) -> float:
    """Return the signal at the ``k``-th sample: slow, within ±1, without a period in samples."""
    return 0.7 * math.sin(0.013 * k) + 0.3 * math.sin(0.0311 * k)
