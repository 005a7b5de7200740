# SPDX-License-Identifier: Apache-2.0
"""Typical values of the parameters for given sensors: where ``tune`` starts."""

from __future__ import annotations

from collections.abc import Mapping

NO_DIFFERENCE = (5e8, 1e9)
"""Break points of a difference that is never large."""

FAR_BEYOND = (4.0, 8.0)
"""A difference becomes large at these multiples of the largest innovation seen."""

DOUBT_IN_MOTION = 2.0 / 3.0
"""W1 when the difference is small and the rate large: S2's noise then counts three times."""


def spike_threshold(scale: float) -> float:
    """Return the threshold of spikes, for the typical distance of a sample from the median."""
    return 8.0 * scale


def rate_time_constant(s2_interval: float) -> float:
    """Return the time constant of the low-pass on dS2/dt, seconds."""
    return 0.3 * s2_interval


def very_large(large: float) -> float:
    """Return the largest weight of Table 1 from the one before it: ``1 - (1 - large)^1.5``."""
    return float(1.0 - (1.0 - large) ** 1.5)


def safety_net(largest: float) -> Mapping[str, float]:
    """Return from which difference on S1 counts as wrong: far beyond any seen.

    Args:
        largest: Largest innovation seen, unit of the signal; 0 if there was none.
    """
    small, large = (
        min(factor * largest, never) if largest > 0.0 else never
        for factor, never in zip(FAR_BEYOND, NO_DIFFERENCE, strict=True)
    )
    return {"aggregator.difference.small": small, "aggregator.difference.large": large}
