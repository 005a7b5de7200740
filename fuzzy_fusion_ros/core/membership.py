# SPDX-License-Identifier: Apache-2.0
"""Membership functions of the aggregator's inputs."""

from __future__ import annotations

from fuzzy_fusion_ros.core.numerics import clamped
from fuzzy_fusion_ros.parameters.fusion import BreakPoints


def large(x: float, ramp: BreakPoints) -> float:
    """Fig. 4: grade of *large* (the paper's G), a linear ramp; *small* is its complement.

    Args:
        x: A non-negative number; infinity is fully large. NaN must not come in.
        ramp: Break points, in the unit of ``x``.

    Returns:
        The grade, 0 up to ``ramp.small`` and 1 from ``ramp.large`` on.
    """
    grade = (x - ramp.small) / (ramp.large - ramp.small)
    return clamped(grade, 0.0, 1.0)
