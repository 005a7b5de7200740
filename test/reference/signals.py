# SPDX-License-Identifier: Apache-2.0
"""Signals to feed: a wandering truth, seen by a noisy S1 and a lagging S2; seeded."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

START_NS = 1_000_000_000


class Recording(NamedTuple):
    """Stamps in nanoseconds and values of both sensors, and which samples of S2 come when.

    ``s2_known[k]`` samples of S2 come before sample ``k`` of S1.
    """

    s1: list[tuple[int, float]]
    s2: list[tuple[int, float]]
    s2_known: list[int]


def regular(samples: int, seed: int = 0, step_ns: int = 10_000_000) -> Recording:
    """Return a recording in which both sensors share evenly spaced stamps, S2 first."""
    stamps = [START_NS + k * step_ns for k in range(samples)]
    return _seen(stamps, stamps, seed)


def irregular(samples: int, seed: int = 0, gap_ns: int = 0) -> Recording:
    """Return a recording with jittered stamps, S2 slower than S1.

    Args:
        samples: Of S1.
        seed: Of all that is random.
        gap_ns: Length of a gap in both sensors in the middle, nanoseconds.
    """
    generator = np.random.default_rng(seed)
    steps = generator.integers(6_000_000, 14_000_000, samples)
    steps[samples // 2] += gap_ns
    stamps = (START_NS + np.cumsum(steps)).tolist()
    offsets = generator.integers(-2_000_000, 1, samples).tolist()
    slower = [s + o for s, o in zip(stamps[::3], offsets, strict=False)]
    return _seen(stamps, slower, seed)


def _seen(s1_ns: list[int], s2_ns: list[int], seed: int) -> Recording:
    generator = np.random.default_rng([seed, 1])
    start, end = min(s1_ns[0], s2_ns[0]), max(s1_ns[-1], s2_ns[-1])
    grid = np.linspace(start, end, 400)
    truth = np.cumsum(generator.normal(0.0, 0.03, grid.size))
    s1 = np.interp(s1_ns, grid, truth) - 0.03 + generator.normal(0.0, 0.05, len(s1_ns))
    s2 = np.interp(np.array(s2_ns) - 100_000_000, grid, truth)
    return Recording(
        s1=list(zip(s1_ns, s1.tolist(), strict=True)),
        s2=list(zip(s2_ns, s2.tolist(), strict=True)),
        s2_known=[sum(other <= stamp for other in s2_ns) for stamp in s1_ns],
    )
