# SPDX-License-Identifier: Apache-2.0
"""First-order complementary filter: S1 for fast changes, S2 for slow ones.

``x = h + l`` with the high-pass ``h_k = a (h_{k-1} + S1_k - S1_{k-1})``, ``a = exp(-dt / T)``
over the actual stamp difference, and the low-pass ``l_k = a l_{k-1} + (1 - a) S2_k``. An S2 that
lags by ``T`` is itself that low-pass; then ``l_k = S2_k``.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.baselines.parameters import ComplementaryParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.parameters.group import numbers


class Complementary(NamedTuple):
    """State of the filter.

    Attributes:
        s1_samples: Samples of S1 so far.
        stamp_ns: Stamp of the last of them.
        s1: S1 after its low-pass.
        s2_samples: Samples of S2 so far.
        s2: The last of them, held.
        high: S1 after the high-pass.
        low: S2 after the low-pass.
    """

    s1_samples: int
    stamp_ns: int
    s1: float
    s2_samples: int
    s2: float
    high: float
    low: float


def complementary(parameters: ComplementaryParameters) -> Method:
    """Return the method."""
    state = Complementary(s1_samples=0, stamp_ns=0, s1=0.0, s2_samples=0, s2=0.0, high=0.0, low=0.0)
    return Method(observe_s2, update, without_s1, numbers(parameters), state)


def observe_s2(
    parameters: ComplementaryParameters, state: Complementary, stamp_ns: int, value: float
) -> Complementary:
    """Hold a sample of S2; the first one starts the low-pass."""
    return Complementary(
        s1_samples=state.s1_samples,
        stamp_ns=state.stamp_ns,
        s1=state.s1,
        s2_samples=state.s2_samples + 1,
        s2=value,
        high=state.high,
        low=state.low if state.s2_samples > 0 else value,
    )


def update(
    parameters: ComplementaryParameters, state: Complementary, stamp_ns: int, value: float
) -> tuple[Estimate, Complementary]:
    """Take a sample of S1 and estimate."""
    s1 = value
    high = 0.0
    share = 0.0
    if state.s1_samples > 0:
        dt = seconds_between(state.stamp_ns, stamp_ns)
        gain = lag_gain(dt, parameters.lowpass_time_constant)
        s1 = (1.0 - gain) * state.s1 + gain * value
        share = lag_gain(dt, parameters.time_constant)
        high = (1.0 - share) * bounded(state.high + (s1 - state.s1))
    low = state.s2 if parameters.s2_lags else (1.0 - share) * state.low + share * state.s2
    kept = Complementary(
        s1_samples=state.s1_samples + 1,
        stamp_ns=stamp_ns,
        s1=s1,
        s2_samples=state.s2_samples,
        s2=state.s2,
        high=high,
        low=low,
    )
    if state.s2_samples == 0:
        return waiting(), kept
    return estimated(bounded(high + low), 1.0 - share), kept


def without_s1(
    parameters: ComplementaryParameters, state: Complementary, stamp_ns: int
) -> Estimate:
    """Estimate at a sample of S2 that has been observed, with S1 held."""
    return update(parameters, state, stamp_ns, state.s1)[0]
