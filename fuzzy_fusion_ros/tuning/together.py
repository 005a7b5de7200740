# SPDX-License-Identifier: Apache-2.0
"""Several recordings taken as one: their typical sensors, and which recordings differ."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.lag import TRUSTED
from fuzzy_fusion_ros.tuning.characterise import Characteristics

OTHER_RATE = 1.5
"""Rates of the same sensor differ by less than this factor from recording to recording."""

OTHER_NOISE = 5.0
"""So does its noise."""

OTHER_LAG = 2.0
"""So does its lag, unless the difference is less than an interval of S2."""

_OTHERS = "in the other recordings"

_MEDIANS = (
    "s1_interval",
    "s2_interval",
    "s2_pause",
    "s1_noise",
    "s2_noise",
    "spike_share",
    "spike_scale",
    "difference",
    "rate",
    "one_way",
)


def typical(sensors: Sequence[Characteristics]) -> Characteristics:
    """Return what the sensors of several recordings are like, as if of one recording.

    Levels are medians, each recording weighted by its length; S2's lag is that of the recording in
    which it is surest; S1's bias scatters within recordings and from one to the next.

    Args:
        sensors: Of each recording.
    """
    if len(sensors) == 1:
        return sensors[0]
    spans = np.array([each.span for each in sensors])
    surest = max(sensors, key=_correlation)
    biases = np.array([each.bias for each in sensors])
    within = np.square([each.wander for each in sensors])
    bias = float(np.average(biases, weights=spans))
    scatter = np.average(within + np.square(biases - bias), weights=spans)
    medians: dict[str, Any] = {
        name: _median(np.array([getattr(each, name) for each in sensors]), spans)
        for name in _MEDIANS
    }
    return surest._replace(
        span=float(spans.sum()),
        s2_gap=max(each.s2_gap for each in sensors),
        s2_delivery=max(each.s2_delivery for each in sensors),
        bias=bias,
        clocks_agree=all(each.clocks_agree for each in sensors),
        drift=float(np.average([each.drift for each in sensors], weights=spans)),
        wander=float(np.sqrt(scatter)),
        **medians,
    )


def oddities(sensors: Characteristics, usual: Characteristics) -> Iterator[str]:
    """Yield in which respects the sensors of a recording are not those of the others.

    Args:
        sensors: Of the recording.
        usual: Typical of all.
    """
    for name, own, others in (
        ("S1", sensors.s1_interval, usual.s1_interval),
        ("S2", sensors.s2_interval, usual.s2_interval),
    ):
        if _differ(own, others, OTHER_RATE):
            yield f"{name} runs at {1.0 / own:.3g} Hz, {_OTHERS} at {1.0 / others:.3g} Hz"
    if _differ(sensors.s1_noise, usual.s1_noise, OTHER_NOISE):
        yield f"S1's noise is {sensors.s1_noise:.2g}, {_OTHERS} {usual.s1_noise:.2g}"
    own_lag, lag = sensors.lag, usual.lag
    if not sensors.related and usual.related:
        yield f"S1 and S2 do not correlate in it (correlation {own_lag.correlation:.2f})"
    elif (
        min(own_lag.correlation, lag.correlation) >= TRUSTED
        and sensors.lag_is_identifiable
        and usual.lag_is_identifiable
        and abs(own_lag.total - lag.total) > usual.s2_interval
        and _differ(own_lag.total, lag.total, OTHER_LAG)
    ):
        yield f"S2 lags {own_lag.total:.2g} s behind S1, {_OTHERS} {lag.total:.2g} s"


def _correlation(sensors: Characteristics) -> float:
    return sensors.lag.correlation


def _differ(a: float, b: float, factor: float) -> bool:
    return max(a, b) > factor * min(a, b)


def _median(values: Reals, weights: Reals) -> float:
    """Return the weighted median, always one of the values."""
    order = np.argsort(values, kind="stable")
    reached = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(reached, 0.5 * reached[-1])])
