"""Conditioning of S1 before the aggregator: our extension, off by default (contract § 7).

Four steps, each of which its parameter of 0 switches off: a spike is left out, the rest goes
through a low-pass, S1's bias is learnt from what S2 would read if S1 were right, and taken off.
Learning slows while the fuzzy rules say that the signal moves.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.aggregator import SlowSensor
from fuzzy_fusion_ros.core.delay_line import DelayLine, delayed, empty_line, extended
from fuzzy_fusion_ros.core.membership import large
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.fusion import (
    BreakPoints,
    FastSensorParameters,
    SlowSensorParameters,
)

LONGEST_INTERVAL = 3
"""S2 that comes later than after so many intervals has had a gap."""

LONGEST_SPIKE = 9
"""So many samples in a row are rejected as spikes at most; then S1 has moved."""


class Smooth(NamedTuple):
    """S1 behind spike rejection and low-pass.

    Attributes:
        level: Where S1 is, roughly: the mean of what it was and of each sample near it.
        trust: How many spikes in a row that outlives, up to ``LONGEST_SPIKE``.
        is_spike: Whether the last sample was one.
        value: Output of the low-pass, unit of the signal.
        slope: Its slope, unit of the signal per second; 0 without a trend.
    """

    level: float
    trust: int
    is_spike: bool
    value: float
    slope: float


class Bias(NamedTuple):
    """What is known of S1's bias.

    Attributes:
        samples: S2 samples learnt from.
        stamp_ns: Stamp of the newest of them.
        interval: Time between the newest two without a gap, seconds; 0 until there are two.
        value: The bias at that stamp, unit of the signal.
        slope: Its drift, unit of the signal per second.
        learnt: Time learnt from, weighted by quietness, faded in gaps, seconds.
    """

    samples: int
    stamp_ns: int
    interval: float
    value: float
    slope: float
    learnt: float


NO_BIAS = Bias(samples=0, stamp_ns=0, interval=0.0, value=0.0, slope=0.0, learnt=0.0)


class Conditioned(NamedTuple):
    """S1 as the aggregator sees it, and what conditioning keeps.

    Attributes:
        samples: S1 samples conditioned since the last start.
        stamp_ns: Stamp of the newest.
        smooth: S1 behind spike rejection and low-pass.
        lagged: S1 behind the model of S2's lag, unit of the signal.
        line: The recent past of ``lagged``, for the model of S2's delay.
        bias: The bias learnt.
        value: ``smooth.value`` less the bias, unit of the signal.
        interval: Time between samples, followed, seconds; 0 before the second.
    """

    samples: int
    stamp_ns: int
    smooth: Smooth
    lagged: float
    line: DelayLine
    bias: Bias
    value: float
    interval: float


def unconditioned() -> Conditioned:
    """Return the state before any S1 sample."""
    return Conditioned(
        samples=0,
        stamp_ns=0,
        smooth=begun(0.0),
        lagged=0.0,
        line=empty_line(),
        bias=NO_BIAS,
        value=0.0,
        interval=0.0,
    )


def condition(
    s1_parameters: FastSensorParameters,
    s2_parameters: SlowSensorParameters,
    rate_ramp: BreakPoints,
    kept: Conditioned,
    s2: SlowSensor,
    stamp_ns: int,
    s1: float,
) -> Conditioned:
    """Take a sample of S1 and return it conditioned.

    The first sample, also the first after a gap longer than S1's timeout, restarts everything
    but the bias.

    Args:
        s1_parameters: The steps' parameters.
        s2_parameters: The model of S2 that the bias is learnt through.
        rate_ramp: Break points of ``|dS2/dt|``: quiet is the grade of *small*.
        kept: What conditioning kept from the last sample.
        s2: S2 as held.
        stamp_ns: Stamp of this sample, later than that of the last.
        s1: The sample, finite.
    """
    if is_off(s1_parameters):
        return passed_through(kept, stamp_ns, s1)
    s1 = bounded(s1)
    dt = seconds_between(kept.stamp_ns, stamp_ns)
    smooth = begun(s1)
    lagged = s1
    line = kept.line
    bias = NO_BIAS
    longest = timeout_for(s1_parameters.timeout, S1_TIMEOUT, kept.interval)
    continues = kept.samples > 0 and dt <= longest
    if continues:
        smooth = low_pass(s1_parameters, kept.smooth, s1, dt)
        passed = smooth.value if smooth.is_spike else s1
        lagged = kept.lagged + lag_gain(dt, s2_parameters.lag_time_constant) * (
            passed - kept.lagged
        )
    if s1_parameters.bias_time_constant > 0.0:
        bias = kept.bias
        if not continues:
            line = empty_line()
        if s2.samples > 0 and s2.stamp_ns != bias.stamp_ns:
            error = delayed(line, stamp_ns, lagged, s2.stamp_ns, s2_parameters.delay)
            error = bounded(error - s2.value)
            quiet = 1.0 - large(abs(s2.rate), rate_ramp)
            bias = learn_bias(s1_parameters, bias, s2.stamp_ns, error, quiet)
        line = extended(line, stamp_ns, lagged, s2_parameters.delay)
    return Conditioned(
        samples=kept.samples + 1,
        stamp_ns=stamp_ns,
        smooth=smooth,
        lagged=lagged,
        line=line,
        bias=bias,
        value=smooth.value - bias_at(s1_parameters, bias, stamp_ns),
        interval=followed(kept.interval, dt) if kept.samples > 0 else 0.0,
    )


def is_off(parameters: FastSensorParameters) -> bool:
    """Return whether every step is switched off: S1 then passes as it is."""
    return (
        parameters.spike_threshold <= 0.0
        and parameters.lowpass_time_constant <= 0.0
        and parameters.bias_time_constant <= 0.0
    )


def passed_through(kept: Conditioned, stamp_ns: int, s1: float) -> Conditioned:
    """Return a sample of S1 as it is; conditioning starts anew when it is switched on."""
    return Conditioned(0, stamp_ns, kept.smooth, kept.lagged, kept.line, NO_BIAS, s1, 0.0)


def begun(s1: float) -> Smooth:
    """Return S1 behind the steps at its first sample, which is taken whatever it is."""
    return Smooth(level=s1, trust=1, is_spike=False, value=s1, slope=0.0)


def low_pass(parameters: FastSensorParameters, kept: Smooth, s1: float, dt: float) -> Smooth:
    """Low-pass a sample that is no spike; with a trend, a ramp passes without lag.

    ``x += slope dt; g = 1 - exp(-dt / T_lp); x += g e; slope += g (1 - exp(-dt / T_trend)) e / dt``
    with ``e`` the sample less the prediction. A spike says nothing: ``e = 0``. It is further than
    ``spike_threshold`` from where S1 is, as long as that is trusted.
    """
    ahead = kept.value + kept.slope * dt
    is_far = abs(s1 - kept.level) > parameters.spike_threshold > 0.0
    if is_far and kept.trust > 0:
        return Smooth(kept.level, kept.trust - 1, True, ahead, kept.slope)
    gain = lag_gain(dt, parameters.lowpass_time_constant)
    error = s1 - ahead
    slope = 0.0
    if parameters.trend_time_constant > 0.0:
        slope = kept.slope + gain * lag_gain(dt, parameters.trend_time_constant) * error / dt
    level = s1 if is_far else 0.5 * (kept.level + s1)
    trust = 0 if is_far else min(kept.trust + 1, LONGEST_SPIKE)
    return Smooth(level, trust, False, ahead + gain * error, slope)


def learn_bias(
    parameters: FastSensorParameters, kept: Bias, stamp_ns: int, error: float, quiet: float
) -> Bias:
    """Move the bias towards an error, the faster the quieter the signal is.

    A first-order lag whose time constant grows with what was learnt, up to
    ``bias_time_constant``: the first estimate is the mean so far. What was learnt fades in a gap,
    so that after it a mean begins again rather than one error counting for all of the gap. With
    a ``drift_time_constant`` the bias also has a slope, learnt likewise.

    Args:
        parameters: Its time constants and the share of learning that goes on in motion.
        kept: The bias so far.
        stamp_ns: Stamp of the S2 sample, later than that of the last.
        error: What S2 would read if S1 were right, less what it reads, unit of the signal.
        quiet: Grade of *the signal is quiet*, 0 to 1.
    """
    if kept.samples == 0:
        return Bias(samples=1, stamp_ns=stamp_ns, interval=0.0, value=error, slope=0.0, learnt=0.0)
    dt = seconds_between(kept.stamp_ns, stamp_ns)
    is_gap = kept.interval > 0.0 and dt > LONGEST_INTERVAL * kept.interval
    interval = kept.interval if is_gap else dt
    share = parameters.bias_moving_share
    weight = (share + (1.0 - share) * quiet) * interval
    elapsed = weight + dt - interval
    longest = parameters.bias_time_constant
    learnt = kept.learnt
    if is_gap:
        learnt = min(learnt, longest) * (1.0 - lag_gain(dt - interval, longest))
    learnt += weight
    gain = lag_gain(weight, min(longest, learnt)) if weight > 0.0 else 0.0
    ahead = bias_at(parameters, kept, stamp_ns)
    slope = kept.slope
    if parameters.drift_time_constant > 0.0:
        slope += gain * lag_gain(elapsed, parameters.drift_time_constant) * (error - ahead) / dt
    return Bias(
        samples=kept.samples + 1,
        stamp_ns=stamp_ns,
        interval=interval,
        value=ahead + gain * (error - ahead),
        slope=slope,
        learnt=learnt,
    )


def bias_at(parameters: FastSensorParameters, bias: Bias, stamp_ns: int) -> float:
    """Return the bias at a stamp, carried on along its slope; 0 before anything was learnt.

    A slope that was learnt over ``T = drift_time_constant`` is believed for about so long:
    ``b + slope T (1 - exp(-dt / T))``, a damped trend; backwards in time alike.
    """
    if bias.samples == 0:
        return 0.0
    dt = seconds_between(bias.stamp_ns, stamp_ns)
    drift = parameters.drift_time_constant
    return bias.value + bias.slope * drift * math.copysign(lag_gain(abs(dt), drift), dt)
