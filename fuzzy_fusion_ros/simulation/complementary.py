"""First-order complementary filter that knows S2's lag: S2 is already one half of it.

Where S2 is the signal behind a first-order lag, S1 behind the high-pass that is complementary to
that lag is all that S2 lacks. With exact sensors this sum *is* the signal.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.clock import seconds_between
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.lag import lag_gain
from fuzzy_fusion_ros.core.series import Method
from fuzzy_fusion_ros.simulation.bare import bare_estimate


class Complement(NamedTuple):
    """What the filter keeps.

    Attributes:
        s2: S2, held.
        started: Whether S1 has spoken.
        stamp_ns: Stamp of the last S1 sample, nanoseconds.
        s1: The last S1 sample.
        fast: S1 behind the high-pass; it starts at rest, as S2's lag does.
    """

    s2: float
    started: bool
    stamp_ns: int
    s1: float
    fast: float


def complement_of_s2(time_constant: float) -> Method:
    """Return the filter for an S2 whose lag has this time constant in s, as a method."""
    nothing = Complement(s2=0.0, started=False, stamp_ns=0, s1=0.0, fast=0.0)
    return Method(observe_s2, update, time_constant, nothing)


def observe_s2(time_constant: float, state: Complement, stamp_ns: int, value: float) -> Complement:
    """Hold a sample of S2; one comes before the first of S1."""
    return Complement(
        s2=value,
        started=state.started,
        stamp_ns=state.stamp_ns,
        s1=state.s1,
        fast=state.fast,
    )


def update(
    time_constant: float, state: Complement, stamp_ns: int, value: float
) -> tuple[Estimate, Complement]:
    """Add S1 behind the high-pass to S2: ``h_k = exp(-dt / T) (h_{k-1} + S1_k - S1_{k-1})``."""
    kept = 1.0 - lag_gain(seconds_between(state.stamp_ns, stamp_ns), time_constant)
    fast = kept * (state.fast + value - state.s1) if state.started else 0.0
    return bare_estimate(state.s2 + fast), Complement(
        s2=state.s2, started=True, stamp_ns=stamp_ns, s1=value, fast=fast
    )
