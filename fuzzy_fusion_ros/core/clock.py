"""Time inside the method: stamps in ``int`` nanoseconds, intervals in seconds."""

from __future__ import annotations

SECOND_NS = 1_000_000_000


def seconds_between(earlier_ns: int, later_ns: int) -> float:
    """Return ``later_ns - earlier_ns`` in seconds; the difference is exact before it is scaled."""
    return (later_ns - earlier_ns) * 1e-9
