# SPDX-License-Identifier: Apache-2.0
"""One measurement of one sensor."""

from __future__ import annotations

from typing import NamedTuple


class Sample(NamedTuple):
    """One measurement.

    Attributes:
        stamp_ns: When it was measured, nanoseconds since the epoch of its clock.
        value: What was measured, unit of the signal; NaN and infinities are possible.
        message: The serialised message that carried it, where an estimate is a copy of it.
    """

    stamp_ns: int
    value: float
    message: bytes = b""
