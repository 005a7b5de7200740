# SPDX-License-Identifier: Apache-2.0
"""From what has been measured to the parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping

from fuzzy_fusion_ros.core.estimator import Sensors
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import allowed, replace
from fuzzy_fusion_ros.self_tuning import homes
from fuzzy_fusion_ros.self_tuning.allan import (
    SIGMA_OVER_USUAL,
    averaging_time,
    root_mean_square,
    usual,
)
from fuzzy_fusion_ros.self_tuning.lag_bank import FoundLag
from fuzzy_fusion_ros.self_tuning.measured import Measured
from fuzzy_fusion_ros.self_tuning.spikes import threshold

AT_ONCE = 1e-6
"""Time constant of a bias that S2 sets at once, seconds."""

NO_LAG = FoundLag(pair=0, lag=0.0, delay=0.0)

FIRST: Mapping[str, float] = {
    "s1.spike_threshold": 0.0,
    "s1.lowpass_time_constant": 0.0,
    "s1.bias_time_constant": AT_ONCE,
    "s1.bias_prior": 0.0,
    "s1.drift_time_constant": 0.0,
    "s1.drift_prior": 0.0,
    "s2.noise": 0.0,
    "s2.lag_time_constant": 0.0,
    "s2.delay": 0.0,
    "aggregator.rate.small": 0.0,
    "aggregator.weight.very_small": 0.0,
    "aggregator.weight.small": 0.0,
    "aggregator.weight.large": 0.0,
    "aggregator.weight.very_large": 0.0,
    "aggregator.drift.small": 0.0,
    "aggregator.drift.large": 0.0,
    **homes.safety_net(0.0),
}
"""Before enough has been measured: S2 as held, plus what S1 has moved since."""


MEASURED = (*FIRST, "aggregator.rate.large", "aggregator.rate_time_constant")
"""Dotted names of the parameters that are measured."""


def first(given: Parameters) -> Parameters:
    """Return the parameters before enough has been measured."""
    return replace(given, FIRST)


def chosen(given: Parameters, measured: Measured, sensors: Sensors, lag: FoundLag) -> Parameters:
    """Return the parameters by what has been measured.

    Args:
        given: Values of what is not measured.
        measured: What has been measured, enough of it.
        sensors: What the estimator keeps of the sensors.
        lag: S2's lag.
    """
    error = root_mean_square(measured.errors)[:, lag.pair]
    sizes = usual(measured.errors)[:, lag.pair]
    smallest = float(sizes[0]) if sizes.size else 0.0
    s1_interval, s2_interval = sensors.s1.interval, sensors.s2.interval
    rate = math.sqrt(measured.rate)
    values = {
        **FIRST,
        "s1.spike_threshold": threshold(measured.spikes),
        "s1.lowpass_time_constant": averaging_time(usual(measured.s1)[:, 0], s1_interval),
        "s1.bias_time_constant": averaging_time(error, s2_interval) or AT_ONCE,
        "s1.bias_prior": float(measured.apart[lag.pair]),
        "s2.noise": smallest * SIGMA_OVER_USUAL,
        "s2.lag_time_constant": lag.lag,
        "s2.delay": lag.delay,
        "aggregator.rate_time_constant": homes.rate_time_constant(s2_interval),
        **homes.safety_net(measured.largest),
    }
    if rate > 0.0:
        large = homes.DOUBT_IN_MOTION
        values["aggregator.rate.large"] = rate
        values["aggregator.weight.large"] = large
        values["aggregator.weight.very_large"] = homes.very_large(large)
    return replace(given, allowed(Parameters, {name: float(each) for name, each in values.items()}))
