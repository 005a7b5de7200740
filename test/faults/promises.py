# SPDX-License-Identifier: Apache-2.0
"""What is promised for the time after a fault: within how many samples all is as before."""

from __future__ import annotations

from typing import Any

from faults.streams import S1

VARIANTS: dict[str, dict[str, Any]] = {
    "plain": {},
    "predictor": {"predictor.enabled": True},
    "paired": {"trigger": "pair", "predictor.enabled": True},
}

OF_S1 = {"stamps ahead": 60, "stamps back": 60}
OF_S2 = {"spikes": 120, "huge": 1600, "stamps ahead": 100, "stamps back": 60}


def promised(fault: str, sensor: str) -> int:
    """Return after how many samples of S1, at 100 Hz, estimates are as without a fault.

    S1 itself leaves no trace in the aggregator. S2 leaves its rate, whose low-pass forgets at
    each sample of S2 by a factor: a spike of height A is felt for a time that grows as log A.
    """
    if sensor == S1:
        return OF_S1.get(fault, 0)
    return OF_S2.get(fault, 50)


def tolerance(changes: dict[str, Any]) -> float:
    """Return how far an estimate may be from that without the fault and count as the same.

    A predictor that learnt something else may move it by half the gate's tolerance, either way.
    """
    return 1e-3 + (0.04 if changes.get("predictor.enabled") else 0.0)
