# SPDX-License-Identifier: Apache-2.0
"""Standard deviation of the estimate: the third consequent of the rules.

The observer's covariance, in which Table 1 sets how far S2 is trusted, gives the shape: it grows
with the time since the last S2. The recent innovations of S2 give the scale: the mean of their
squares over the expected ones. While the observer is off there is no covariance; then the
size is that of ``S1 - S2`` and the shape its growth with S2's age.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import LARGEST, bounded

MEMORY = 20
"""Samples of S2 that the size is a mean over."""

FIRST = 10
"""Samples of S2 that its noise, where it is known, counts as at first."""

SHOCK = 25.0
"""A sample counts as at most this many times the mean, or S2's known noise where that is larger: an
outlier says nothing of the noise now."""

OUTLIER = 2.0
"""The same for a sample that the observer has found to be an outlier."""


class Evidence(NamedTuple):
    """What S2's innovations say.

    Attributes:
        samples: How many of them, up to ``MEMORY``.
        variance: Mean of their squares, each over what was expected of it, unit of the signal
            squared.
    """

    samples: int
    variance: float


def no_evidence() -> Evidence:
    """Return what is known before any innovation."""
    return Evidence(samples=0, variance=0.0)


def weighed(
    kept: Evidence, noise: float, innovation: float, expected: float, most: float = SHOCK
) -> Evidence:
    """Take another innovation.

    Args:
        kept: The evidence so far.
        noise: S2's noise, unit of the signal; 0 where it is not known.
        innovation: The innovation.
        expected: Its expected square, in units of S2's noise variance, 1 or more.
        most: How many times the mean, or the noise if that is larger, it counts as at most.
    """
    samples, variance = kept.samples, kept.variance
    if samples == 0 and noise > 0.0:
        samples, variance = FIRST, noise * noise
    error = bounded(innovation)
    squared = min(error * error / expected, LARGEST)
    if variance > 0.0:
        squared = min(squared, most * max(variance, noise * noise))
    samples = min(samples + 1, MEMORY)
    return Evidence(samples, variance + (squared - variance) / samples)


def deviation(scale: float, floor: float, evidence: Evidence, variance: float) -> float:
    """Return the standard deviation of the estimate's error, unit of the signal.

    Args:
        scale: ``estimate.deviation_scale``.
        floor: Standard deviation of what is independent of S2's noise, unit of the signal.
        evidence: What S2's innovations say.
        variance: Of what is believed, in units of S2's noise variance.
    """
    return scale * math.sqrt(evidence.variance * variance + floor * floor)
