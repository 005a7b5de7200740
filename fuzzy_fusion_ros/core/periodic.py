# SPDX-License-Identifier: Apache-2.0
"""Angles and other signals that repeat: the nearest value that is a whole number of turns away."""

from __future__ import annotations

import math

from fuzzy_fusion_ros.core.numerics import bounded


def turns(value: float, reference: float, period: float) -> int:
    """Return how many turns a value is ahead of the one nearest to a reference.

    Args:
        value: Finite, unit of the signal.
        reference: The same.
        period: A turn, above 0.
    """
    return math.ceil(bounded(value - reference) / period - 0.5)


def nearest(value: float, reference: float, period: float) -> float:
    """Return a value, whole turns away, that is nearest to a reference.

    Half a turn off, it is the one above: the nearest to 0 is above -period/2, up to period/2.
    """
    return value - period * turns(value, reference, period)
