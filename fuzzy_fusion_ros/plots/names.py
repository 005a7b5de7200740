# SPDX-License-Identifier: Apache-2.0
"""Colours and names of what figures and reports show: one colour per method, everywhere.

The colours are those of Okabe and Ito, which colour-blind readers can tell apart, and a few
shades of grey.
"""

from __future__ import annotations

from types import MappingProxyType

COLOURS = MappingProxyType(
    {
        "truth": "#000000",
        "ideal": "#000000",
        "s1": "#B3B3B3",
        "s2": "#0072B2",
        "average": "#56B4E9",
        "constant_weight": "#7F6D5F",
        "no_drift": "#F0E442",
        "aggregator": "#E69F00",
        "complete": "#D55E00",
        "estimate": "#D55E00",
        "complementary": "#009E73",
        "complementary_lowpass": "#66C2A5",
        "kalman": "#CC79A7",
        "kalman_bias": "#882255",
        "kalman_lag": "#44AA99",
        "kalman_lag_cv": "#117733",
        "error_state": "#332288",
    }
)

NAMES = MappingProxyType(
    {
        "truth": "truth",
        "ideal": "ideal sensor",
        "s1": "S1",
        "s2": "S2",
        "average": "average of S1 and S2",
        "constant_weight": "constant weight",
        "no_drift": "aggregator without drift",
        "aggregator": "aggregator",
        "complete": "aggregator and predictor",
        "estimate": "estimate",
        "complementary": "complementary filter",
        "complementary_lowpass": "complementary filter, S1 low-passed",
        "kalman": "Kalman filter",
        "kalman_bias": "Kalman filter with S1's bias",
        "kalman_lag": "Kalman filter with S2's lag",
        "kalman_lag_cv": "Kalman filter with S2's lag and a velocity",
        "error_state": "error-state filter",
    }
)


def difference_name(observes: bool) -> str:
    """Return what the rules call the difference: with the observer the innovation of S2."""
    return "|innovation of S2|" if observes else "|S1 − S2|"


def with_unit(text: str, unit: str, between: str = " / ") -> str:
    """Return a label with its unit, if that is known, and with squares written as ²."""
    return f"{text}{between}{unit.replace('^2', '²')}" if unit else text
