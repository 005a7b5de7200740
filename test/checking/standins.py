# SPDX-License-Identifier: Apache-2.0
"""Made-up pairs of sensors of many kinds, as they should be or with one fault each."""

from __future__ import annotations

import zlib
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.samples import SensorSamples, TwoSensors

START_NS = 1_700_000_000_000_000_000
STEP = 0.005
"""Seconds between points of the signal."""

WARM_UP = round(60.0 / STEP)
"""Points of noise before the first that is used, so that a lag has forgotten where it started."""


class Track(NamedTuple):
    """Samples of one sensor.

    Attributes:
        time_s: When they were measured, seconds from the start, shape (n,).
        stamp_s: What their stamps say, seconds from the start, shape (n,).
        arrival_s: When they arrive, seconds from the start, shape (n,).
        values: Shape (n,).
    """

    time_s: Reals
    stamp_s: Reals
    arrival_s: Reals
    values: Reals


class Pair(NamedTuple):
    """Two sensors, S2 behind a lag and S1 noisy, off and drifting.

    Attributes:
        s1: The fast one.
        s2: The accurate one.
    """

    s1: Track
    s2: Track

    def sensors(self) -> TwoSensors:
        """Return them as a check takes them."""
        return TwoSensors(_samples("s1", self.s1), _samples("s2", self.s2), START_NS)


Motion = Callable[[np.random.Generator, Reals], Reals]
"""Makes a signal at some times."""


def _sine(rng: np.random.Generator, time_s: Reals) -> Reals:
    wave: Reals = np.sin(2.0 * np.pi * time_s / rng.uniform(3.0, 12.0) + rng.uniform(0.0, 6.0))
    return wave


def _sines(rng: np.random.Generator, time_s: Reals) -> Reals:
    waves = [
        rng.normal() * np.sin(2.0 * np.pi * time_s / rng.uniform(2.0, 20.0) + rng.uniform(0.0, 6.0))
        for _ in range(4)
    ]
    total: Reals = np.sum(waves, axis=0)
    return total


def _restless(rng: np.random.Generator, time_s: Reals) -> Reals:
    """Noise behind two lags."""
    time_constant = rng.uniform(0.7, 4.0)
    noise = rng.normal(size=time_s.size + WARM_UP)
    return _unit(lagged(lagged(noise, time_constant), time_constant / 2.0)[WARM_UP:])


def _walk(rng: np.random.Generator, time_s: Reals) -> Reals:
    return _unit(lagged(np.cumsum(rng.normal(size=time_s.size)), rng.uniform(0.3, 1.0)))


def _steps(rng: np.random.Generator, time_s: Reals) -> Reals:
    edges = np.sort(rng.uniform(0.0, time_s[-1], max(3, int(time_s[-1] / rng.uniform(3.0, 8.0)))))
    levels = rng.normal(size=edges.size + 1)
    return lagged(levels[np.searchsorted(edges, time_s)], rng.uniform(0.1, 0.6))


def _swing(rng: np.random.Generator, time_s: Reals) -> Reals:
    """A pendulum that comes to rest and is pushed at random."""
    swing = np.exp(-2.0 * time_s / time_s[-1]) * np.sin(
        2.0 * np.pi * time_s / rng.uniform(0.8, 3.0)
    )
    pushes = 3.0 * lagged(rng.normal(size=time_s.size + WARM_UP), 1.0)[WARM_UP:]
    return lagged(swing + pushes, 0.05)


def _warm_up(rng: np.random.Generator, time_s: Reals) -> Reals:
    """A heater that is switched on, and a room that is not quite still."""
    rise: Reals = 1.0 - np.exp(-time_s / rng.uniform(0.1, 0.5) / time_s[-1])
    return rise + 0.1 * _restless(rng, time_s)


MOTIONS: dict[str, Motion] = {
    "sine": _sine,
    "four sines": _sines,
    "restless": _restless,
    "walk": _walk,
    "steps": _steps,
    "swing": _swing,
    "warm-up": _warm_up,
}

FAULTS = (
    "none",
    "negated",
    "negated, noise in one half",
    "scale 57.3",
    "scale 1/57.3",
    "scale 9.81",
    "scale 3.6",
    "scale 1/100",
    "scale 5",
    "s1 is the rate",
    "s2 is the rate",
    "s2 5 s behind",
    "s2 1.5 s ahead",
    "s2 from boot",
    "s1 restarts at 0",
    "s2 0.8 s late",
    "exchanged",
    "s1 stuck",
    "s2 stuck",
    "s1 stuck in the second half",
    "2 % spikes",
    "10 % spikes",
    "unrelated",
)


def pair(motion: str, fault: str, seed: int) -> Pair:
    """Make two sensors.

    Args:
        motion: How the signal moves, one of ``MOTIONS``.
        fault: What is wrong, one of ``FAULTS``.
        seed: Of everything random; rates, lags and noise depend on it too.
    """
    rng = np.random.default_rng([seed, zlib.crc32(motion.encode())])
    span = float(rng.choice([30.0, 60.0, 120.0]))
    time_s = np.arange(0.0, span, STEP)
    truth = MOTIONS[motion](rng, time_s) * 10.0 ** rng.uniform(-1.0, 1.0)
    s1, s2 = truth, truth
    if fault == "s1 is the rate":
        s1 = np.gradient(truth, STEP)
    if fault == "s2 is the rate":
        s2 = np.gradient(truth, STEP)
    if fault == "unrelated":
        other = np.random.default_rng([seed, 1])
        s2 = MOTIONS[motion](other, time_s) * float(np.std(truth))
    lag, share = float(rng.choice([0.0, 0.1, 0.3, 0.6, 0.9])), rng.uniform()
    s2 = np.interp(time_s - lag * (1.0 - share), time_s, lagged(s2, lag * share))
    rate1 = int(rng.choice([50, 100, 200]))
    rate2 = int(rng.choice([1, 5, 10, 20, rate1]))
    drift = rng.uniform(-1.0, 1.0) + rng.uniform(-1.0, 1.0) * time_s / span
    s1 = s1 + float(np.std(s1)) * (drift + rng.uniform(0.02, 0.5) * rng.normal(size=s1.size))
    s2 = s2 + float(np.std(s2)) * rng.uniform(0.005, 0.08) * rng.normal(size=s2.size)
    made = Pair(_sampled(rng, time_s, s1, rate1), _sampled(rng, time_s, s2, rate2))
    return _with_fault(made, fault, rng)


def lagged(values: Reals, time_constant: float) -> Reals:
    """Return a signal behind a first-order lag, seconds; without one for 0."""
    if time_constant == 0.0:
        return values
    kernel = np.exp(-np.arange(round(12.0 * time_constant / STEP)) * STEP / time_constant)
    size = 1 << (values.size + kernel.size).bit_length()
    spectrum = np.fft.rfft(values - values[0], size) * np.fft.rfft(kernel / kernel.sum(), size)
    found: Reals = np.fft.irfft(spectrum, size)[: values.size] + values[0]
    return found


def _unit(values: Reals) -> Reals:
    found: Reals = values / np.std(values)
    return found


def _sampled(rng: np.random.Generator, time_s: Reals, values: Reals, rate: int) -> Track:
    chosen = slice(None, None, round(1.0 / (rate * STEP)))
    times = time_s[chosen]
    return Track(times, times, times + rng.exponential(0.002, times.size), values[chosen])


def _with_fault(made: Pair, fault: str, rng: np.random.Generator) -> Pair:
    s1, s2 = made
    if fault.startswith("negated"):
        s1 = s1._replace(values=-s1.values)
    if fault.endswith("noise in one half"):
        noise = 3.0 * float(np.std(s1.values)) * rng.normal(size=s1.values.size)
        is_late = s1.time_s >= 0.5 * s1.time_s[-1]
        s1 = s1._replace(values=s1.values + np.where(is_late == rng.integers(2), noise, 0.0))
    if fault.startswith("scale "):
        over, _, under = fault.removeprefix("scale ").partition("/")
        s1 = s1._replace(values=s1.values * float(over) / float(under or 1.0))
    behind = {"s2 5 s behind": 5.0, "s2 1.5 s ahead": -1.5, "s2 from boot": 1.69e9}.get(fault, 0.0)
    s2 = s2._replace(stamp_s=s2.stamp_s - behind)
    if fault == "s1 restarts at 0":
        later = s1.time_s >= 0.5 * s1.time_s[-1]
        restarted = s1.time_s - s1.time_s[later][0] + 0.01 - START_NS * 1e-9
        s1 = s1._replace(stamp_s=np.where(later, restarted, s1.stamp_s))
    if fault == "s2 0.8 s late":
        s2 = s2._replace(arrival_s=s2.arrival_s + 0.8)
    if fault == "exchanged":
        s1, s2 = s2, s1
    if fault in {"s1 stuck", "s2 stuck"}:
        s1, s2 = (
            each._replace(values=np.full_like(each.values, each.values[0]))
            if fault.startswith(name)
            else each
            for name, each in (("s1", s1), ("s2", s2))
        )
    if fault == "s1 stuck in the second half":
        half = s1.values.size // 2
        s1 = s1._replace(values=np.append(s1.values[:half], np.full(s1.values.size - half, 0.1)))
    if "spikes" in fault:
        share = float(fault.split()[0]) / 100.0
        size = rng.choice([-1.0, 1.0], s1.values.size) * rng.uniform(3.0, 8.0, s1.values.size)
        spikes = (rng.uniform(size=s1.values.size) < share) * size * float(np.std(s1.values))
        s1 = s1._replace(values=s1.values + spikes)
    return Pair(s1, s2)


def _samples(name: str, track: Track) -> SensorSamples:
    return SensorSamples(
        name=name,
        topic=f"/{name}",
        field="data",
        unit="",
        is_stamped=True,
        stamps_ns=START_NS + np.rint(track.stamp_s * 1e9).astype(np.int64),
        overflows=np.zeros(track.values.size, np.bool_),
        arrivals_ns=START_NS + np.rint(track.arrival_s * 1e9).astype(np.int64),
        values=track.values,
    )
