# SPDX-License-Identifier: Apache-2.0
"""Validity gate."""

from __future__ import annotations


def final(prediction: float | None, aggregate: float, tolerance: float) -> float:
    """Return the mean of prediction and aggregate if they agree, else the aggregate."""
    if prediction is not None and abs(prediction - aggregate) <= tolerance:
        return (prediction + aggregate) / 2
    return aggregate
