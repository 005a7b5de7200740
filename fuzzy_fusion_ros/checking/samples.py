"""The samples of two sensors as they came, before anything is dropped."""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps


class SensorSamples(NamedTuple):
    """Everything that one sensor has sent, in order of arrival.

    Attributes:
        name: ``s1`` or ``s2``.
        topic: The topic, ``""`` where there is none.
        field: Where the number is in its messages.
        unit: Unit of the number, ``""`` where the type does not tell.
        is_stamped: Whether its messages carry a stamp; if not, ``stamps_ns`` is ``arrivals_ns``.
        stamps_ns: When they were measured, whatever the stamps say, shape (n,), nanoseconds.
        overflows: Whether the nanoseconds of a stamp are a second or more, shape (n,).
        arrivals_ns: When they arrived or were recorded, shape (n,), nanoseconds.
        values: What was measured, NaN and infinities included, shape (n,).
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

    def kept(self, which: Flags) -> SensorSamples:
        """Return some of the samples, shape (n,) says which."""
        return self._replace(
            stamps_ns=self.stamps_ns[which],
            overflows=self.overflows[which],
            arrivals_ns=self.arrivals_ns[which],
            values=self.values[which],
        )


class TwoSensors(NamedTuple):
    """What a check looks at.

    Attributes:
        s1: The fast sensor.
        s2: The accurate one.
        start_ns: Arrival time that the seconds in texts count from, nanoseconds.
    """

    s1: SensorSamples
    s2: SensorSamples
    start_ns: int
