"""One measurement of one sensor."""

from __future__ import annotations

from typing import NamedTuple


class Sample(NamedTuple):
    """One measurement.

    Attributes:
        stamp_ns: When it was measured, nanoseconds since the epoch of its clock.
        value: What was measured, unit of the signal; NaN and infinities are possible.
    """

    stamp_ns: int
    value: float
