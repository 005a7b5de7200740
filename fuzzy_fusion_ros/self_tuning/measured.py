# SPDX-License-Identifier: Apache-2.0
"""What running statistics say of the sensors: bounded in memory, of the samples alone."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.core.conditioning import FastSensor
from fuzzy_fusion_ros.core.estimator import Sensors
from fuzzy_fusion_ros.core.numerics import bounded, seconds_between
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, timeout_for
from fuzzy_fusion_ros.self_tuning.allan import Octaves, Reals, counted, no_octaves
from fuzzy_fusion_ros.self_tuning.lag_bank import LAGS, LagBank, lag_bank, passed
from fuzzy_fusion_ros.self_tuning.spikes import NO_SPIKES, Spikes, judged

S1_OCTAVES, S2_OCTAVES = 12, 9
S1_MEMORY, S2_MEMORY = 1 << 13, 1 << 9
"""Octaves of Allan's statistics, and pairs of samples that they remember."""

KNOWN_INTERVAL = 5
"""Samples of S2 after which its interval is known."""

GAP = 3.0
"""A sample is missing where the time between two is this many intervals."""


class Measured(NamedTuple):
    """What has been measured.

    Attributes:
        s1: Allan's statistic of S1.
        spikes: S1's spikes.
        bank: S1 through k - 1 models of S2, ``None`` before S2's interval is known.
        samples: Samples of S2 compared with the bank.
        s2_ns: Stamp of the newest sample of S2.
        s2: Its value.
        errors: Allan's statistic of S1 through each model, minus S2; and last of 0 minus S2.
        apart: Running mean of the size of that, shape (k,).
        rate: Running mean of the square of dS2/dt.
        late: Running mean of how long after its stamp S2 came, seconds, on S1's stamps.
        largest: Largest innovation of S2 seen through a lag, unit of the signal.
    """

    s1: Octaves
    spikes: Spikes
    bank: LagBank | None
    samples: int
    s2_ns: int
    s2: float
    errors: Octaves
    apart: Reals
    rate: float
    late: float
    largest: float


def nothing_measured() -> Measured:
    """Return the state before any sample."""
    series = 2 + 2 * LAGS
    return Measured(
        s1=no_octaves(S1_OCTAVES, 1),
        spikes=NO_SPIKES,
        bank=None,
        samples=0,
        s2_ns=0,
        s2=0.0,
        errors=no_octaves(S2_OCTAVES, series),
        apart=np.zeros(series),
        rate=0.0,
        late=0.0,
        largest=0.0,
    )


def heard_s1(kept: Measured, before: FastSensor, s1: FastSensor) -> Measured:
    """Take a sample of S1.

    Args:
        kept: What has been measured so far.
        before: S1 before the sample.
        s1: S1 with it, conditioned.
    """
    smooth = s1.smooth
    value = smooth.newest if smooth.rejected <= 0.0 else smooth.value
    octaves = counted(kept.s1, np.array([value]), s1.samples == 1, S1_MEMORY)
    bank = kept.bank
    if bank is not None and s1.samples == 1:
        shown = np.full(bank.lags.size, smooth.value)
        bank = bank._replace(first=shown, second=shown)
    elif bank is not None:
        bank = passed(bank, seconds_between(before.stamp_ns, s1.stamp_ns), smooth.value)
    return kept._replace(s1=octaves, spikes=judged(kept.spikes, smooth.newest), bank=bank)


def heard_s2(
    kept: Measured, sensors: Sensors, patience: float, stamp_ns: int, value: float
) -> Measured:
    """Take a sample of S2. While S1 is silent there is nothing to compare it with.

    Args:
        kept: What has been measured so far.
        sensors: What the estimator keeps of the sensors, this sample included.
        patience: S1's timeout, seconds; 0 is automatic.
        stamp_ns: Its stamp.
        value: The sample, finite.
    """
    interval, s1 = sensors.s2.interval, sensors.s1
    value = bounded(value)
    longest = timeout_for(patience, S1_TIMEOUT, s1.interval)
    if kept.bank is None or seconds_between(s1.stamp_ns, stamp_ns) > longest:
        if kept.bank is None and sensors.s2.samples >= KNOWN_INTERVAL and s1.samples > 0:
            kept = kept._replace(bank=lag_bank(interval, s1.smooth.value))
        return kept._replace(s2_ns=stamp_ns, s2=value)
    dt = seconds_between(kept.s2_ns, stamp_ns)
    is_gap = dt > GAP * interval
    error = np.append(kept.bank.second, 0.0) - value
    samples = kept.samples + 1
    share = 1.0 / min(samples, 2 * S2_MEMORY)
    rate = kept.rate
    if not is_gap and dt > 0.0:
        rate += share * (((value - kept.s2) / dt) ** 2 - rate)
    return kept._replace(
        samples=samples,
        s2_ns=stamp_ns,
        s2=value,
        errors=counted(kept.errors, error, is_gap, S2_MEMORY),
        apart=kept.apart + share * (np.abs(error) - kept.apart),
        rate=min(rate, 1e100),
        late=kept.late + share * (max(seconds_between(stamp_ns, s1.stamp_ns), 0.0) - kept.late),
    )
