# SPDX-License-Identifier: Apache-2.0
"""Conditioning of S1 on its own: our extension, off by default.

Two steps, each switched off by a parameter of 0: spikes are left out, and the rest goes through
a low-pass with a trend. Its bias is learnt from S2 in :mod:`observer`.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.numerics import bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.fusion import FastSensorParameters

LONGEST_SPIKE = 9
"""Without S2's evidence, at most this many samples in a row are spikes; then S1 has stepped."""

TREND = 5.0
"""Time constant of the low-pass's slope, in time constants of the low-pass."""


class Smooth(NamedTuple):
    """S1 without spikes and low-passed.

    Attributes:
        level: Where S1 is, roughly: the mean of what it was and of each sample near it.
        trust: How many spikes in a row ``level`` outlives, up to ``LONGEST_SPIKE``.
        value: S1 without spikes and low-passed, unit of the signal.
        slope: Its slope, unit of the signal per second.
        rejected: For how long samples have been rejected, seconds; 0 if the newest was not.
        newest: The newest sample, rejected or not, unit of the signal.
        step: How far S1 has just been moved to samples that were rejected for longer than its
            timeout, unit of the signal; 0 at all other samples.
    """

    level: float
    trust: int
    value: float
    slope: float
    rejected: float
    newest: float
    step: float


class FastSensor(NamedTuple):
    """S1 as conditioned.

    Attributes:
        samples: Samples since the first or the last gap; 0 while every step is off.
        stamp_ns: Stamp of the newest.
        interval: Time between samples, followed, seconds; 0 before the second.
        smooth: S1 without spikes and low-passed.
    """

    samples: int
    stamp_ns: int
    interval: float
    smooth: Smooth


def no_fast_sensor() -> FastSensor:
    """Return the state before any S1 sample."""
    return FastSensor(samples=0, stamp_ns=0, interval=0.0, smooth=begun(0.0))


def is_off(parameters: FastSensorParameters) -> bool:
    """Return whether S1 passes as it is: neither conditioned nor corrected by an observer."""
    return (
        parameters.spike_threshold <= 0.0
        and parameters.lowpass_time_constant <= 0.0
        and parameters.bias_time_constant <= 0.0
    )


def condition(
    parameters: FastSensorParameters,
    kept: FastSensor,
    rate: float,
    s2_decides: bool,
    stamp_ns: int,
    s1: float,
) -> FastSensor:
    """Take a sample of S1 and return it conditioned.

    The first sample, also the first after a gap longer than S1's timeout, restarts everything
    and is taken whatever it is.

    Args:
        parameters: The steps' parameters.
        kept: What conditioning kept from the last sample.
        rate: dS2/dt, along which S1 is carried on while it is rejected.
        s2_decides: Whether only S2 can say that S1 has stepped; else enough samples in a row do.
        stamp_ns: Stamp of this sample, later than that of the last.
        s1: The sample, finite.
    """
    if is_off(parameters):
        return FastSensor(0, stamp_ns, 0.0, begun(s1))
    s1 = bounded(s1)
    dt = seconds_between(kept.stamp_ns, stamp_ns)
    longest = timeout_for(parameters.timeout, S1_TIMEOUT, kept.interval)
    samples = 1
    smooth = begun(s1)
    if kept.samples > 0 and dt <= longest:
        samples = kept.samples + 1
        smooth = smoothed(parameters, kept.smooth, rate, s2_decides, longest, dt, s1)
    return FastSensor(
        samples=samples,
        stamp_ns=stamp_ns,
        interval=followed(kept.interval, dt) if kept.samples > 0 else 0.0,
        smooth=smooth,
    )


def smoothed(
    parameters: FastSensorParameters,
    kept: Smooth,
    rate: float,
    s2_decides: bool,
    longest: float,
    dt: float,
    s1: float,
) -> Smooth:
    """Leave a sample out if it is a spike, else low-pass it.

    A sample further than ``spike_threshold`` from where S1 is, is a spike as long as that is
    trusted. Where S2 decides it is one until S2 has said otherwise, for at most S1's timeout.

    Args:
        parameters: The steps' parameters.
        kept: S1 so far.
        rate: dS2/dt.
        s2_decides: Whether only S2 can say that S1 has stepped.
        longest: S1's timeout, seconds.
        dt: Time since the last sample, seconds.
        s1: The sample.
    """
    is_far = abs(s1 - kept.level) > parameters.spike_threshold > 0.0
    if not is_far:
        return low_pass(parameters, kept, dt, s1)
    if not s2_decides and kept.trust <= 0:
        return stepped_to(s1, 0.0)
    passed = carried_on(parameters, kept, rate, dt, s1)
    if s2_decides and passed.rejected > longest:
        return stepped_to(s1, s1 - passed.value)
    return passed


def begun(s1: float) -> Smooth:
    """Return S1 at its first sample, which is taken whatever it is."""
    return Smooth(s1, 1, s1, 0.0, 0.0, s1, 0.0)


def stepped_to(s1: float, step: float) -> Smooth:
    """Return S1 at a sample that turned out to be no spike.

    Args:
        s1: The sample.
        step: The step that the bias has to take with it; 0 if the signal itself has moved.
    """
    return Smooth(level=s1, trust=0, value=s1, slope=0.0, rejected=0.0, newest=s1, step=step)


def low_pass(parameters: FastSensorParameters, kept: Smooth, dt: float, s1: float) -> Smooth:
    """Low-pass a sample with a trend, so that a ramp passes without lag.

    ``x += slope dt; g = 1 - exp(-dt / T); x += g e; slope += g (1 - exp(-dt / T_trend)) e / dt``
    with ``e`` the sample minus the prediction and ``T_trend = TREND T``.
    """
    ahead = kept.value + kept.slope * dt
    gain = lag_gain(dt, parameters.lowpass_time_constant)
    learnt = gain * lag_gain(dt, TREND * parameters.lowpass_time_constant)
    error = s1 - ahead
    return Smooth(
        level=0.5 * (kept.level + s1),
        trust=min(kept.trust + 1, LONGEST_SPIKE),
        value=bounded(ahead + gain * error),
        slope=bounded(kept.slope + learnt * error / dt),
        rejected=0.0,
        newest=s1,
        step=0.0,
    )


def carried_on(
    parameters: FastSensorParameters, kept: Smooth, rate: float, dt: float, s1: float
) -> Smooth:
    """Carry S1 on through a rejected sample; its slope fades to the rate that S2 shows.

    The slope before a run of spikes may itself be spoilt, so it is forgotten as fast as learnt.
    """
    fade = lag_gain(dt, TREND * parameters.lowpass_time_constant)
    slope = kept.slope + fade * (rate - kept.slope)
    return Smooth(
        level=bounded(kept.level + slope * dt),
        trust=max(kept.trust - 1, 0),
        value=bounded(kept.value + slope * dt),
        slope=slope,
        rejected=kept.rejected + dt,
        newest=s1,
        step=0.0,
    )
