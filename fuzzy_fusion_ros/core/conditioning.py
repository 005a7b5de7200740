"""Conditioning of S1 before the aggregator: our extension, off by default (contract § 7)."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.aggregator import SlowSensor
from fuzzy_fusion_ros.core.clock import seconds_between
from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.core.parameters import AggregatorParameters, FastSensorParameters


class Conditioned(NamedTuple):
    """S1 as the aggregator sees it, and what conditioning keeps.

    Attributes:
        samples: S1 samples since the last start.
        stamp_ns: Stamp of the newest.
        lowpassed: S1 behind its low-pass, unit of the signal.
        bias: Estimated bias of S1, unit of the signal.
        value: ``lowpassed - bias``.
    """

    samples: int
    stamp_ns: int
    lowpassed: float
    bias: float
    value: float


def unconditioned() -> Conditioned:
    """Return the state before any S1 sample."""
    return Conditioned(samples=0, stamp_ns=0, lowpassed=0.0, bias=0.0, value=0.0)


def lag_step(value: float, target: float, dt: float, time_constant: float) -> float:
    """One step of a first-order lag: backward Euler, stable for every ``dt`` >= 0.

    A time constant of 0 passes ``target`` through.
    """
    if time_constant <= 0.0:
        return target
    return value + (target - value) * (dt / (time_constant + dt))


def condition(
    parameters: FastSensorParameters,
    aggregator: AggregatorParameters,
    kept: Conditioned,
    s2: SlowSensor,
    stamp_ns: int,
    s1: float,
) -> Conditioned:
    """Low-pass S1 and take off its bias, learnt while the rules say that the signal is quiet.

    Args:
        parameters: The two time constants, 0 for off.
        aggregator: Its break points of ``|dS2/dt|``: learning follows the grade of *small*.
        kept: What conditioning kept from the last sample.
        s2: S2 as held.
        stamp_ns: Stamp of this sample, later than that of the last.
        s1: The sample, finite.
    """
    dt = seconds_between(kept.stamp_ns, stamp_ns)
    lowpassed = s1
    if kept.samples > 0 and dt <= parameters.timeout:
        lowpassed = lag_step(kept.lowpassed, s1, dt, parameters.lowpass_time_constant)
    bias = kept.bias
    if parameters.bias_time_constant > 0.0 and kept.samples > 0 and s2.samples > 0:
        quiet = 1.0 - large(abs(s2.rate), aggregator.rate)
        bias = lag_step(bias, lowpassed - s2.value, dt * quiet, parameters.bias_time_constant)
    return Conditioned(
        samples=kept.samples + 1,
        stamp_ns=stamp_ns,
        lowpassed=lowpassed,
        bias=bias,
        value=lowpassed - bias,
    )
