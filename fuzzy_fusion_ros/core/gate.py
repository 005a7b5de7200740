# SPDX-License-Identifier: Apache-2.0
"""The validity gate between prediction and aggregate."""

from __future__ import annotations

from typing import NamedTuple


class Prediction(NamedTuple):
    """A prediction, or none.

    Attributes:
        exists: Whether there is one.
        value: The predicted estimate, unit of the signal; 0 where there is none.
    """

    exists: bool
    value: float


NO_PREDICTION = Prediction(exists=False, value=0.0)


def accepts(prediction: Prediction, aggregate: float, tolerance: float) -> bool:
    """Fig. 5: whether there is a prediction within ``tolerance`` of FA's output."""
    return prediction.exists and abs(prediction.value - aggregate) <= tolerance


def combine(prediction: Prediction, aggregate: float, accepted: bool) -> float:
    """Fig. 5: the final estimate, the mean of both where the gate accepts, else FA's output."""
    if accepted:
        return 0.5 * prediction.value + 0.5 * aggregate
    return aggregate
