# SPDX-License-Identifier: Apache-2.0
"""The observer's model of S2, a first-order lag and then a delay: what S2 would show of S1.

The model is linear, so S1 and its bias pass it apart: S1 with the true delay, at the stamp of the
sample however late that comes; the bias, which changes slowly, with a second lag in place of the
delay. Both times are those of the parameters times a factor, 1 unless it is adapted.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.covariance import Gain
from fuzzy_fusion_ros.core.delay_line import DelayLine, delayed, empty_line, extended
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain
from fuzzy_fusion_ros.parameters.fusion import SlowSensorParameters


class Shown(NamedTuple):
    """S1 on its way through S2's model.

    Attributes:
        lagged: S1 behind the lag, unit of the signal.
        line: The recent past of that, for the delay.
    """

    lagged: float
    line: DelayLine


class Lagged(NamedTuple):
    """S1's bias as it shows behind the lag, and behind the second lag that stands for the delay."""

    first: float
    second: float


class States(NamedTuple):
    """What S2 corrects, and S1 on its way to it.

    Attributes:
        bias: What conditioned S1 is off by, unit of the signal.
        slope: Its slope, unit of the signal per second.
        through: The bias as S2 would show it.
        shown: S1 as S2 would show it.
    """

    bias: float
    slope: float
    through: Lagged
    shown: Shown


def no_states() -> States:
    """Return the states before any sample."""
    return States(0.0, 0.0, Lagged(0.0, 0.0), Shown(0.0, empty_line()))


def lag_gains(parameters: SlowSensorParameters, factor: float, dt: float) -> tuple[float, float]:
    """Return the gains of the lag, and of that in place of the delay, over ``dt`` seconds."""
    lag, delay = factor * parameters.lag_time_constant, factor * parameters.delay
    return lag_gain(dt, lag), lag_gain(dt, delay)


def shown_on(shown: Shown, gain: float, stamp_ns: int, value: float, reach: float) -> Shown:
    """Return S1 through S2's model after another sample.

    Args:
        shown: As it was.
        gain: Of the lag over the step, 0 to 1.
        stamp_ns: Stamp of the sample.
        value: The sample.
        reach: How far back samples of S2 look, seconds.
    """
    lagged = bounded(shown.lagged + gain * (value - shown.lagged))
    return Shown(lagged, extended(shown.line, stamp_ns, lagged, reach))


def shown_at(
    parameters: SlowSensorParameters, factor: float, shown: Shown, newest_ns: int, stamp_ns: int
) -> float:
    """Return what S2 would show of S1 at a stamp.

    Args:
        parameters: Of S2.
        factor: Of its lag and delay.
        shown: S1 through S2's lag.
        newest_ns: Stamp of S1's newest sample.
        stamp_ns: The stamp of S2.
    """
    return delayed(shown.line, newest_ns, shown.lagged, stamp_ns, factor * parameters.delay)


def carried(states: States, shown: Shown, dt: float, first: float, second: float) -> States:
    """Return the states after some time: the bias along its slope, and through the lags.

    Args:
        states: As they were.
        shown: S1 as S2 would show it after that time.
        dt: The time, seconds.
        first, second: Gains of the lags over it.
    """
    was = states.through
    bias = bounded(states.bias + states.slope * dt)
    behind = bounded(was.first + first * (bias - was.first))
    through = Lagged(behind, bounded(was.second + second * (behind - was.second)))
    return States(bias, states.slope, through, shown)


def corrected_states(states: States, shown: Shown, k: Gain, innovation: float) -> States:
    """Return the states after a sample of S2.

    Args:
        states: As they were.
        shown: S1 as S2 would show it: what ``states`` hold, or what turned out to be right.
        k: How much of the innovation each state takes.
        innovation: The innovation, believed minus measured.
    """
    was = states.through
    return States(
        bounded(states.bias + k.bias * innovation),
        bounded(states.slope + k.slope * innovation),
        Lagged(
            bounded(was.first + k.first * innovation),
            bounded(was.second + k.second * innovation),
        ),
        shown,
    )


def shifted_states(states: States, less: States, more: States, share: float) -> States:
    """Return the states, their bias moved by a share of what ``more`` has more than ``less``.

    Args:
        states: As they were.
        less, more: Other states.
        share: The share.
    """
    was, low, high = states.through, less.through, more.through
    return States(
        bounded(states.bias + share * (more.bias - less.bias)),
        bounded(states.slope + share * (more.slope - less.slope)),
        Lagged(
            bounded(was.first + share * (high.first - low.first)),
            bounded(was.second + share * (high.second - low.second)),
        ),
        states.shown,
    )
