"""The exact first-order lag that conditioning, sensor model and controller share."""

from __future__ import annotations

import math


def lag_gain(dt: float, time_constant: float) -> float:
    """Return ``1 - exp(-dt / time_constant)``, the share of the way that one step goes.

    A time constant of 0 goes all of it.
    """
    if time_constant <= 0.0:
        return 1.0
    return 1.0 - math.exp(-dt / time_constant)
