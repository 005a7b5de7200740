# SPDX-License-Identifier: Apache-2.0
"""Whether the sensors' clocks agree, judged by when samples arrive and what their stamps say."""

from __future__ import annotations

from fuzzy_fusion_ros.online.guard import Guard

NOTICEABLE = 0.25
"""Seconds: a smaller offset is normal for clocks and transport on a robot."""

SUSPICIOUS = 2.0
"""Seconds: no sensor's messages take longer than this to arrive."""

STEADY = 0.5
"""An offset is between clocks if delays grow by less than this share of it while observed.
In a recording played at another rate without ``use_sim_time`` they grow by more than the offset,
which is then between a sensor that has been observed for long and one that has not."""

SYNCHRONIZE = "synchronize the clocks that stamp them, or stamp both on receipt"
"""What to do about clocks that are apart."""


def offset_between(s1: Guard, s2: Guard) -> float | None:
    """Return how far S2's stamps are behind S1's when both arrive, seconds.

    Negative where they are ahead; ``None`` while too few samples have arrived.
    """
    if s1.delay is None or s2.delay is None:
        return None
    return s2.delay - s1.delay


def clock_problem(s1: Guard, s2: Guard, s1_timeout: float, s2_timeout: float) -> str:
    """Describe the offset between the sensors' clocks, ``""`` while it is harmless.

    It is not where a sensor that is present counts as lost, where stamps arrive before their time,
    and where a delay is longer than any transport.

    Args:
        s1, s2: The guards.
        s1_timeout, s2_timeout: After how long each counts as lost, seconds.
    """
    offset = offset_between(s1, s2)
    if offset is None or s1.delay is None or s2.delay is None or abs(offset) <= NOTICEABLE:
        return ""
    if max(abs(s1.delay_growth), abs(s2.delay_growth)) > STEADY * abs(offset):
        return ""
    harmless = min(SUSPICIOUS, s2_timeout if offset > 0.0 else s1_timeout)
    if abs(offset) <= harmless and min(s1.delay, s2.delay) >= -NOTICEABLE:
        return ""
    problem = f"{apart(offset)} although both arrive together: {SYNCHRONIZE}"
    if min(s1.delay, s2.delay) >= -NOTICEABLE and abs(offset) <= SUSPICIOUS:
        late = "s2" if offset > 0.0 else "s1"
        problem += f"; if the messages of {late} are late, set {late}.timeout: 0.0"
    return problem


def apart(behind: float) -> str:
    """Say how S2's stamps stand to S1's: ``s2's stamps are 5.0 s behind s1's``.

    Args:
        behind: How far they are behind, seconds; negative if they are ahead.
    """
    where = "behind" if behind > 0.0 else "ahead of"
    return f"s2's stamps are {duration(abs(behind))} {where} s1's"


def duration(seconds: float) -> str:
    """Return a duration in words: ``0.25 s``, ``5.0 s``, ``1.76e9 s``."""
    if seconds < 1.0:
        return f"{seconds:.2g} s"
    if seconds < 1e5:
        return f"{seconds:.1f} s"
    mantissa, _, exponent = f"{seconds:.2e}".partition("e")
    return f"{mantissa}e{int(exponent)} s"
