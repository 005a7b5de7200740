# SPDX-License-Identifier: Apache-2.0
"""The raw samples of two sensors, before anything is dropped."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps
from fuzzy_fusion_ros.parameters.fusion import Parameters


class SensorSamples(NamedTuple):
    """Everything that one sensor has sent, in order of arrival.

    Attributes:
        name: ``s1`` or ``s2``.
        topic: The topic, ``""`` where there is none.
        field: Where the number is in its messages.
        unit: Unit of the number, ``""`` where the type states none.
        is_stamped: Whether its messages carry a stamp; if not, ``stamps_ns`` is ``arrivals_ns``.
        stamps_ns: When they were measured, whatever the stamps say, shape (n,), nanoseconds.
        overflows: Whether the nanoseconds of a stamp are a second or more, shape (n,).
        arrivals_ns: When they arrived or were recorded, shape (n,), nanoseconds.
        values: What was measured, NaN and infinities included, shape (n,).
        scale: What ``scale`` of the sensor is set to; it is part of the values.
        unreadable: How many more messages lack the number.
        rejects_from: What is set to reject its outliers: ``s1.spike_threshold``, or
            ``s2.outlier_threshold``, which is in standard deviations; 0 if nothing is.
        frames: Each ``frame_id`` of some of its messages whenever it is not that of the one before.
        elements: Each name that some of its messages give the element of an array that is read.
        meaningless: Where the values say nothing of the motion, see :mod:`.direction`, shape (n,);
            None if that is nowhere or not known.
    """

    name: str
    topic: str
    field: str
    unit: str
    is_stamped: bool
    stamps_ns: Stamps
    overflows: Flags
    arrivals_ns: Stamps
    values: Reals
    scale: float = 1.0
    unreadable: int = 0
    rejects_from: float = 0.0
    frames: tuple[str, ...] = ()
    elements: tuple[str, ...] = ()
    meaningless: Flags | None = None

    @property
    def sound(self) -> Flags:
        """Where the values are finite and mean something, shape (n,)."""
        finite: Flags = np.isfinite(self.values)
        return finite if self.meaningless is None else finite & ~self.meaningless

    def kept(self, which: Flags) -> SensorSamples:
        """Return some of the samples, shape (n,) says which."""
        return self._replace(
            stamps_ns=self.stamps_ns[which],
            overflows=self.overflows[which],
            arrivals_ns=self.arrivals_ns[which],
            values=self.values[which],
            meaningless=None if self.meaningless is None else self.meaningless[which],
        )


class TwoSensors(NamedTuple):
    """What a check looks at.

    Attributes:
        s1: The fast sensor.
        s2: The accurate one.
        start_ns: Arrival time that the seconds in texts count from, nanoseconds.
        period: ``signal.period``; 0 unless it is set.
        is_rate: Whether ``s1.kind`` says that S1 is a rate.
        unit: ``signal.unit``; ``""`` unless it is set.
    """

    s1: SensorSamples
    s2: SensorSamples
    start_ns: int
    period: float = 0.0
    is_rate: bool = False
    unit: str = ""


def two_sensors(
    s1: SensorSamples, s2: SensorSamples, start_ns: int, parameters: Parameters
) -> TwoSensors:
    """Return sensors as the parameters see them.

    Args:
        s1: S1.
        s2: S2.
        start_ns: As in :class:`TwoSensors`.
        parameters: Say whether the signal wraps, whether S1 is a rate, what rejects outliers, and
            the unit, which overrides what the types state.
    """
    signal = parameters.signal
    observes = parameters.s1.bias_time_constant > 0.0  # without, no outlier of S2 is rejected
    s1 = s1._replace(rejects_from=parameters.s1.spike_threshold)
    s2 = s2._replace(rejects_from=parameters.s2.outlier_threshold if observes else 0.0)
    if signal.unit:
        s1, s2 = s1._replace(unit=""), s2._replace(unit="")
    is_rate = parameters.s1.kind == "rate"
    return TwoSensors(s1, s2, start_ns, signal.period, is_rate, signal.unit)
