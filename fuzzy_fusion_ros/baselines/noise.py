# SPDX-License-Identifier: Apache-2.0
"""Noise as the robust filters model it: more of it in motion, and the tails of Student's t."""

from __future__ import annotations

from fuzzy_fusion_ros.core.numerics import bounded

DEGREES_OF_FREEDOM = 4.0
"""Of Student's t-distribution."""

FINEST = 1e6
"""Largest ratio of prior to measurement standard deviation that filters take into account: beyond
it, rounding errors would dominate."""


def variance_in_motion(at_rest: float, in_motion: float, rate: float) -> float:
    """Return the variance of S2's noise while S2 changes.

    Args:
        at_rest: Scale of the noise at rest, unit of the signal.
        in_motion: Scale of the noise in motion, in multiples of the rate, seconds.
        rate: dS2/dt, unit of the signal per second.
    """
    moving = bounded(in_motion * rate)
    return at_rest * at_rest + moving * moving


def robust_variance(variance: float, prior: float, innovation: float) -> float:
    """Return the variance with which a measurement counts: the larger, the further off it is.

    One step of the re-weighted least squares of Student's t-distribution.

    Args:
        variance: Squared scale of the measurement's noise, more than 0.
        prior: Variance of what is measured, before the measurement.
        innovation: The measurement minus its expectation, within ``LARGEST``.
    """
    far = innovation * innovation / (prior + variance)
    return variance * ((DEGREES_OF_FREEDOM + far) / (DEGREES_OF_FREEDOM + 1.0))
