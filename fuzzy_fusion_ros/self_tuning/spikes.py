# SPDX-License-Identifier: Apache-2.0
"""S1's spikes: how far samples are from the median around them, and how many are far off."""

from __future__ import annotations

import itertools
import math
import statistics
from typing import NamedTuple

from fuzzy_fusion_ros.self_tuning.homes import spike_threshold

WINDOW = 11
"""Samples in the median: few, so that motion is not taken for a spike."""

QUANTILE = 0.8
"""Of the distances from the median this many are below twice the usual one."""

SPIKE_SIGMAS = 5.0
"""A sample this many times the usual distance from the median is a spike."""

FEWEST_SPIKES = 0.015
"""At this share and above, spikes are a fault of the sensor; fewer are the tail of its noise."""

SIGMA_OVER_MEDIAN = 1.4826
"""Standard deviation of normal numbers of mean 0, over the median of their magnitudes."""

MEMORY = 2000
"""Samples of S1 that the statistics are of."""

_MOVE = 0.005
_SMALLEST = 1e-12


class Spikes(NamedTuple):
    """What is kept of S1's spikes.

    Attributes:
        newest: The newest samples, up to ``WINDOW``.
        samples: Samples judged, up to ``MEMORY``.
        distance: Running ``QUANTILE`` of the distance from the median, unit of the signal.
        share: Share of samples that are spikes.
        height: Square root of the usual distance of a spike, weighted with ``share``.
    """

    newest: tuple[float, ...]
    samples: int
    distance: float
    share: float
    height: float


NO_SPIKES = Spikes((), 0, 0.0, 0.0, 0.0)


def judged(kept: Spikes, s1: float) -> Spikes:
    """Take a sample of S1, and judge the one in the middle of the newest.

    The quantile moves by a small share of itself, up more than down, so that the size of a
    spike does not matter. A sample is a spike if it is far off by that, and by the steps around
    it, which are large in motion.

    Args:
        kept: What is kept so far.
        s1: The sample, finite.
    """
    newest = (*kept.newest[-WINDOW + 1 :], s1)
    if len(newest) < WINDOW:
        return kept._replace(newest=newest)
    distance = abs(newest[WINDOW // 2] - statistics.median(newest))
    step = statistics.median([abs(b - a) for a, b in itertools.pairwise(newest)])
    samples = min(kept.samples + 1, MEMORY)
    usual = kept.distance if kept.samples else distance
    move = max(1.0 / samples, _MOVE)
    usual = max(usual * math.exp(move * (QUANTILE - (distance <= usual))), _SMALLEST)
    scale = SIGMA_OVER_MEDIAN * max(usual / 2.0, step)
    root = math.sqrt(distance) if distance > SPIKE_SIGMAS * scale else 0.0
    return Spikes(
        newest,
        samples,
        usual,
        kept.share + ((root > 0.0) - kept.share) / samples,
        kept.height + (root - kept.height) / samples,
    )


def threshold(kept: Spikes) -> float:
    """Return from which step on a sample is to be left out, 0 if S1 has no spikes to speak of."""
    if kept.share < FEWEST_SPIKES:
        return 0.0
    usual = spike_threshold(SIGMA_OVER_MEDIAN * kept.distance / 2.0)
    return max(usual, 0.25 * (kept.height / kept.share) ** 2)
