# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the numbers of one sensor: not finite, spikes, an angle that wraps."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, white_noise
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import SensorSamples
from fuzzy_fusion_ros.core.numerics import LARGEST
from fuzzy_fusion_ros.online.guard import Drop

PERIODS = {2.0 * math.pi: "2 pi", 360.0: "360 degrees"}
"""Where angles wrap, in their unit, and its name."""

NEAR = 0.25
"""Share of the period by which a step may differ from a whole turn, or from none, and values from
the ends of the turn."""

EXACT, FAST = 0.05, 4.0
"""A turn is off a whole one by less than this share of it and this many usual steps."""

RARE = 0.3
"""Of steps that are neither, noise or spikes make more than turns are; an angle that means nothing
at rest makes about as many."""

HALF_WINDOW = 2
"""Samples each way in the median that shows spikes: those of up to two samples stand out."""

BLOCK = 50
"""Samples whose usual step is taken for that of each of them."""

USUAL = 0.6
"""Quantile of the steps that is the usual step: spikes of one sample in ten do not change it."""

STANDS_OUT = (6.0, 4.0)
"""A spike is this many usual steps off: those around it, and those of the recording. White noise
alone reaches 6 of its usual steps once in 10^12 samples."""

FEWEST = 20
"""In fewer samples nothing is a spike."""

MANY_SPIKES = (0.01, 10)
"""At this share and this number, spikes are a fault of the sensor rather than of the moment."""

SOME_SPIKES = 5
"""Fewer are not reported."""


FAR = 30.0
"""Outliers are this many times as far from the median as any other sample. In real recordings, no
sample is twice as far as 99.9 % of them."""

ENOUGH = 200
"""In fewer samples they are further by the ratio: the range of a few samples says little. Of as
many, one more may be an outlier in a row."""

MOST_OUTLIERS = (5, 0.001, 0.05)
"""At most this many samples or this share, whichever is more, are outliers; of few samples at most
this share, but always one."""


REJECTED_BY = {"s1": "s1.spike_threshold", "s2": "s2.outlier_threshold"}
"""The parameters that reject outliers and spikes."""


class Wrap(NamedTuple):
    """An angle that jumps by a whole turn.

    Attributes:
        period: The turn, unit of the signal; 0 if there is none.
        jumps: How often it jumps.
    """

    period: float
    jumps: int

    def unwrapped(self, values: Reals) -> Reals:
        """Return an angle without its jumps; steps of more than a quarter turn are left out."""
        if self.period == 0.0:
            return values
        steps = np.diff(values)
        steps -= self.period * np.round(steps / self.period)
        steps[np.abs(steps) > NEAR * self.period] = 0.0
        unwrapped: Reals = values[0] + np.append(0.0, np.cumsum(steps))
        return unwrapped


def wrap_of(values: Reals) -> Wrap:
    """Return where an angle wraps.

    Args:
        values: Finite, shape (n,).
    """
    values = np.clip(values, -LARGEST, LARGEST)  # differences of numbers at the limit overflow
    steps = np.abs(np.diff(values))
    largest = steps.max(initial=0.0)
    for period in PERIODS:
        if largest < (1.0 - NEAR) * period or not _fits(values, period):
            continue
        top = period if values.min() > -NEAR * period else 0.5 * period
        ends = np.minimum(np.abs(values - top), np.abs(values - (top - period))) < NEAR * period
        off = np.minimum(FAST * np.median(steps) + EXACT * period, NEAR * period)
        turns = (np.abs(steps - period) < off) & ends[1:] & ends[:-1]
        between = (steps > NEAR * period) & (steps < (1.0 - NEAR) * period)
        jumps = int(np.count_nonzero(turns))
        if jumps > RARE * np.count_nonzero(between):
            return Wrap(period, jumps)
    return Wrap(0.0, 0)


def _fits(values: Reals, period: float) -> bool:
    return values.size > 1 and bool(np.ptp(values) <= period * (1.0 + NEAR))


def spikes_of(values: Reals) -> Flags:
    """Return which samples jump off and back, shape (n,).

    Instead of ``batch.cleaning.without_spikes``, which is made for a sensor that shakes and takes
    6 % of the samples of a slow one that moves now and then for spikes.

    Args:
        values: Finite, shape (n,).
    """
    n = values.size
    if n < FEWEST:
        return np.zeros(n, np.bool_)
    padded = np.pad(values, HALF_WINDOW, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * HALF_WINDOW + 1)
    distance = np.abs(values - np.median(windows, axis=1))
    steps = np.abs(np.diff(values, append=values[-1]))
    resolution = steps[steps > 0.0].min(initial=np.inf)
    blocks = np.sort(np.pad(steps, (0, -n % BLOCK), mode="reflect").reshape(-1, BLOCK))
    usual = np.pad(blocks[:, int(USUAL * BLOCK)], 1, mode="edge")
    around = np.repeat(np.maximum(np.maximum(usual[:-2], usual[1:-1]), usual[2:]), BLOCK)[:n]
    overall = float(np.quantile(steps, USUAL))
    least = np.maximum(STANDS_OUT[0] * around, STANDS_OUT[1] * overall)
    spikes: Flags = distance > np.maximum(least, STANDS_OUT[0] * resolution)
    return spikes


class Outliers(NamedTuple):
    """Few samples that are absurdly far from all others.

    Attributes:
        which: Which they are, shape (n,).
        last: Those of them in which the samples end, without others as far before: they may stay,
            shape (n,).
        others: How far from the median the others are at most.
        factor: The outliers are further than the others by more than this.
    """

    which: Flags
    last: Flags
    others: float
    factor: float


def outliers_of(values: Reals) -> Outliers:
    """Return outliers: few samples that are far from all others, and after which these go on.

    A movement from rest is none: it goes through the values between, or stays.

    Args:
        values: Finite, shape (n,).
    """
    n = values.size
    count, share, largest_share = MOST_OUTLIERS
    most = max(1, min(count, int(largest_share * n)), int(share * n))
    factor = FAR * max(1.0, ENOUGH / max(n, 1))
    if n <= most + 1:
        nothing = np.zeros(n, np.bool_)
        return Outliers(nothing, nothing, math.inf, factor)
    distance = np.abs(values - np.median(values))
    usual = np.partition(distance, n - 1 - most)[n - 1 - most]
    far = _in_short_runs(distance > factor * usual, max(1, n // ENOUGH))
    others = float(distance[~far].max())
    which = far & (distance > factor * others) & (others > 0.0)
    end = np.flatnonzero(~which)[-1] + 1
    last = which.copy()
    last[:end] = False
    last &= distance < distance[:end][which[:end]].min(initial=math.inf)
    return Outliers(which, last, others, factor)


def _in_short_runs(flags: Flags, longest: int) -> Flags:
    """Return a copy of the flags in which every run longer than ``longest`` is cleared."""
    edges = np.flatnonzero(np.diff(flags, prepend=False, append=False))
    starts, ends = edges[::2], edges[1::2]
    kept = flags.copy()
    for start, end in zip(starts, ends, strict=True):
        kept[start:end] = end - start <= longest
    return kept


class Values(NamedTuple):
    """The values of a sensor, judged.

    Attributes:
        clean: The finite ones without wraps, spikes and outliers, shape (k,); on lines where they
            mean nothing.
        noise: Standard deviation of their white noise.
        spikes: Share of them that were spikes.
        findings: What is wrong.
    """

    clean: Reals
    noise: float
    spikes: float
    findings: tuple[Finding, ...]


def judge_values(
    samples: SensorSamples,
    period: float,
    *,
    is_known: bool = False,
    is_rate: bool = False,
    start_ns: int = 0,
) -> Values:
    """Judge the values of a sensor by themselves.

    Args:
        samples: Of the sensor; at least three with finite values.
        period: Where the other sensor wraps, unit of the signal; 0 if it does not.
        is_known: Whether the parameters say so, too; then wraps are no fault.
        is_rate: Whether it is integrated: limits then apply to the integral.
        start_ns: Arrival time that the seconds in texts count from, nanoseconds.
    """
    name, n = samples.name, samples.values.size
    finite = samples.kept(np.isfinite(samples.values))
    values = np.clip(finite.values, -LARGEST, LARGEST)  # differences at the limit overflow
    findings = []
    if values.size < n:
        text = f"{n - values.size} of {n} samples of {name} are dropped: {Drop.NOT_FINITE.value}"
        findings.append(Finding(Level.WARNING, "not finite", text, {}))
    outliers = outliers_of(values)
    lasting = finite.kept(outliers.last)
    if lasting.values.size:
        findings.append(_may_stay(lasting, values.size, outliers.factor))
    if lasting.values.size < np.count_nonzero(outliers.which):
        findings.append(_outliers(finite, outliers, start_ns, is_rate=is_rate))
    values = _without(outliers.which, values)
    sound = finite.sound
    values = values[sound]
    wrap = Wrap(0.0, 0) if is_known else wrap_of(values)
    if wrap.jumps:
        text = f"{name} wraps: it jumps by {PERIODS[wrap.period]}, {wrap.jumps} times"
        remedy = f"signal.period: {wrap.period:.10g}"
        findings.append(Finding(Level.WARNING, "wrap", text, {}, remedy))
    elif _fits(values, period):
        wrap = Wrap(period, 0)
    unwrapped = wrap.unwrapped(values)
    spikes = spikes_of(unwrapped)
    clean = _without(spikes, unwrapped)
    count = int(np.count_nonzero(spikes))
    if count >= SOME_SPIKES:
        size = float(np.median(np.abs(unwrapped - clean)[spikes]))
        findings.append(_spikes(finite, count, size, is_rate=is_rate))
    noise = white_noise(clean)
    return Values(on_lines(clean, sound), noise, count / values.size, tuple(findings))


def _without(spikes: Flags, values: Reals) -> Reals:
    """Return values with spikes replaced by lines between the samples about them."""
    return on_lines(values[~spikes], ~spikes)


def on_lines(values: Reals, where: Flags) -> Reals:
    """Return a series on straight lines between the places where it is known.

    Args:
        values: There, shape (k,).
        where: Which places these are, shape (n,).
    """
    if where.all():
        return values
    return np.interp(np.arange(where.size), np.flatnonzero(where), values)


def _may_stay(last: SensorSamples, of: int, factor: float) -> Finding:
    largest = last.values[np.argmax(np.abs(last.values))]
    text = (
        f"{last.name} ends far off: {last.values.size} of {of} samples, up to {largest:.3g}, over "
        f"{factor:.3g} times as far from the median as any other: a step, or garbage"
    )
    return Finding(Level.INFO, "last samples", text, {})


def _outliers(
    samples: SensorSamples, outliers: Outliers, start_ns: int, *, is_rate: bool
) -> Finding:
    found = samples.kept(outliers.which & ~outliers.last)
    count, of = found.values.size, samples.values.size
    largest = found.values[np.argmax(np.abs(found.values))]
    at_s = (int(found.arrivals_ns[0]) - start_ns) * 1e-9
    text = (
        f"{samples.name} has outliers: {count} of {of} samples, up to {largest:.3g}, over "
        f"{outliers.factor:.3g} times as far from the median as any other, the first at "
        f"{at_s:.1f} s"
    )
    limit = 3.0 * outliers.others  # no two of the others are further apart than twice that
    nearest = (outliers.factor - 1.0) * outliers.others
    return _rejectable(samples, "outliers", text, limit, nearest, is_rate=is_rate)


def _spikes(samples: SensorSamples, count: int, size: float, *, is_rate: bool) -> Finding:
    name, of = samples.name, samples.values.size
    text = f"{name} has spikes: {count} of {of} samples jump off and back, half by over {size:.2g}"
    if count < max(MANY_SPIKES[0] * of, MANY_SPIKES[1]):
        return Finding(Level.INFO, "spikes", text, {})
    return _rejectable(samples, "spikes", text, 0.5 * size, size, is_rate=is_rate)


def _rejectable(
    samples: SensorSamples, about: str, text: str, limit: float, most: float, *, is_rate: bool
) -> Finding:
    """Return the finding of samples that a parameter rejects, or is set to reject.

    Args:
        samples: The sensor.
        about: Name of the finding.
        text: The observation.
        limit: A step from which on a sample is to be rejected, unit of the samples.
        most: A larger one that rejects at least half of the samples.
        is_rate: Whether it is integrated: steps are then those of the integral.
    """
    interval = float(np.median(np.diff(samples.arrivals_ns))) * 1e-9 if is_rate else 1.0
    limit, most = limit * interval, most * interval
    name, threshold = REJECTED_BY[samples.name], samples.rejects_from
    if threshold > 0.0 and (samples.name == "s2" or threshold <= most):
        return Finding(Level.INFO, about, f"{text}; handled by {name}: {threshold:.7g}", {})
    if samples.name == "s2":
        remedy = f"{name}: 4, which needs s1.bias_time_constant > 0: tune fits both"
    else:
        remedy = f"{name}: {limit:.2g}" if limit > 0.0 else "filter them in its driver"
    return Finding(Level.WARNING, about, text, {}, remedy)
