# SPDX-License-Identifier: Apache-2.0
"""Stand-ins for recordings: made-up sensors of many kinds, none of them just as ours are modelled.

Each has a cause of trouble that real sensors have: S2 behind a moving window, a second-order
low-pass or a delay that jitters; an S1 that drifts like a gyroscope, slips, saturates in spikes
or has the wrong scale; gaps; halves that differ. ``evaluate.py`` tunes on the first half of each
and scores on the second.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter
from tuning.recordings import START_NS, Made

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import Series


class Standin(NamedTuple):
    """A kind of recording; all of it in units of the signal and seconds.

    Attributes:
        motion: How the signal moves: turns, swings, drives, ranges or heats.
        busy: Which half has most of the motion: both, first or second.
        seconds: Length.
        s1_hz: Rate of S1.
        s2_hz: Rate of S2.
        noise: Standard deviation of S1's white noise.
        bias: Of S1.
        slope: Of S1's bias: a gyroscope's constant rate bias.
        wander: How far that slope walks in the square root of a second.
        walk: How far the bias walks in the square root of a second.
        scale: What S1 makes of the signal's size.
        strain: Share of the signal's second derivative that S1 also sees, s^2.
        slip: Share of a positive first derivative that S1 also sees, s.
        spikes: Share of S1's samples that begin a spike.
        longest_spike: Samples that one lasts at most.
        late: S1's errors but its noise begin in the second half.
        window: S2 is the mean over so long.
        order: Of the low-pass behind S2.
        lag: Time constant of each of its stages.
        delay: Of S2.
        jitter: Standard deviation of that, as a share.
        s2_noise: Standard deviation of S2's white noise.
        quantum: Step that S2 is rounded to.
        outliers: Share of S2's samples that are far off.
        gaps: Shortest and longest gap in S2.
    """

    motion: str
    busy: str = "both"
    seconds: float = 240.0
    s1_hz: float = 20.0
    s2_hz: float = 4.0
    noise: float = 0.02
    bias: float = 0.0
    slope: float = 0.0
    wander: float = 0.0
    walk: float = 0.0
    scale: float = 1.0
    strain: float = 0.0
    slip: float = 0.0
    spikes: float = 0.0
    longest_spike: int = 1
    late: bool = False
    window: float = 0.0
    order: int = 1
    lag: float = 0.0
    delay: float = 0.0
    jitter: float = 0.0
    s2_noise: float = 0.01
    quantum: float = 0.0
    outliers: float = 0.0
    gaps: tuple[float, float] = (0.0, 0.0)


STANDINS = MappingProxyType(
    {
        "turns_gaps": Standin(
            "turns", seconds=500.0, s1_hz=10.0, s2_hz=1.0, noise=0.004, slope=0.004, wander=3e-4,
            delay=0.4, s2_noise=0.03, gaps=(10.0, 60.0),
        ),
        "turns_walk": Standin(
            "turns", seconds=500.0, s1_hz=10.0, s2_hz=1.0, noise=0.004, walk=0.05,
            delay=0.2, lag=0.3, s2_noise=0.03, gaps=(20.0, 40.0),
        ),
        "turns_scale": Standin(
            "turns", busy="second", s1_hz=20.0, s2_hz=2.0, noise=0.01, slope=-0.01, scale=1.03,
            lag=0.6, s2_noise=0.04,
        ),
        "swings_gyro": Standin(
            "swings", seconds=160.0, s1_hz=40.0, s2_hz=10.0, noise=0.005, bias=0.05, slope=0.006,
            wander=3e-4, scale=1.01, order=2, lag=0.25, s2_noise=0.02,
        ),
        "swings_quiet": Standin(
            "swings", busy="second", seconds=160.0, s1_hz=40.0, s2_hz=10.0, noise=0.01, walk=0.02,
            lag=0.4, s2_noise=0.01,
        ),
        "swings_strain": Standin(
            "swings", busy="first", seconds=160.0, s1_hz=40.0, s2_hz=8.0, noise=0.1, bias=0.06,
            strain=0.006, window=0.3, delay=0.1, jitter=0.3, s2_noise=0.01,
        ),
        "drives_window": Standin(
            "drives", seconds=400.0, s1_hz=15.0, s2_hz=1.0, noise=0.15, scale=1.03, slip=0.05,
            window=1.0, delay=0.4, s2_noise=0.04,
        ),
        "drives_jitter": Standin(
            "drives", busy="second", s1_hz=20.0, s2_hz=5.0, noise=0.3, scale=0.98, bias=0.1,
            delay=0.5, jitter=0.2, s2_noise=0.08, quantum=0.1,
        ),
        "drives_busy": Standin(
            "drives", busy="first", s1_hz=20.0, s2_hz=2.0, noise=0.1, walk=0.05, slip=0.1,
            order=2, lag=0.4, delay=0.2, s2_noise=0.05,
        ),
        "ranges_spikes": Standin(
            "ranges", s1_hz=20.0, s2_hz=3.0, noise=0.02, bias=0.05, spikes=0.1, lag=0.5,
            delay=0.1, s2_noise=0.01,
        ),
        "ranges_runs": Standin(
            "ranges", busy="second", s1_hz=20.0, s2_hz=2.0, noise=0.03, scale=0.98, spikes=0.05,
            longest_spike=4, window=0.8, s2_noise=0.01,
        ),
        "ranges_outliers": Standin(
            "ranges", s1_hz=20.0, s2_hz=5.0, noise=0.05, bias=-0.1, walk=0.01, spikes=0.02,
            longest_spike=3, lag=0.4, s2_noise=0.01, quantum=0.02, outliers=0.03,
        ),
        "block_temp": Standin(
            "heats", seconds=14400.0, s1_hz=1.0 / 3.0, s2_hz=1.0 / 3.0, noise=0.5, bias=2.0,
            walk=0.01, lag=150.0, delay=10.0, s2_noise=0.05,
        ),
        "late_drift": Standin(
            "swings", s1_hz=20.0, s2_hz=5.0, noise=0.03, slope=0.01, walk=0.02, late=True,
            lag=0.4, s2_noise=0.01,
        ),
    }
)  # fmt: skip
"""What a setting has to beat the baselines on."""

HOSTILE = MappingProxyType(
    {
        "s1_noise": Standin("swings", noise=-1.0, lag=0.3),
        "s1_perfect": Standin("swings", noise=0.001, lag=0.6, s2_noise=0.15),
        "s1_biased": Standin("ranges", noise=0.002, bias=0.2, lag=0.6, s2_noise=0.1),
        "s1_stuck": Standin("ranges", scale=0.0, noise=0.01, lag=0.2),
        "s2_perfect": Standin("swings", noise=0.3, walk=0.1, s2_hz=20.0, s2_noise=0.001),
        "both_perfect": Standin("swings", noise=0.0, s2_hz=20.0, s2_noise=0.0),
    }
)
"""One sensor is all that one needs: no worse than it is enough. Negative noise: nothing else."""


def standin(name: str, seed: int) -> Made:
    """Make a recording of a kind.

    Args:
        name: Of :data:`STANDINS` or :data:`HOSTILE`.
        seed: Of everything in it.
    """
    kind = {**STANDINS, **HOSTILE}[name]
    generator = np.random.default_rng([seed, *name.encode()])
    dt = 1.0 / kind.s1_hz
    s1_s = np.asarray(np.arange(round(kind.seconds * kind.s1_hz)) * dt, np.float64)
    truth = _MOTIONS[kind.motion](generator, s1_s, _activity(generator, s1_s, kind))
    s1_ns = START_NS + np.round(s1_s * 1e9).astype(np.int64)
    s1 = _fast(generator, kind, s1_s, truth)
    s2_s, s2 = _slow(generator, kind, s1_s, truth)
    s2_ns = START_NS + np.round(s2_s * 1e9).astype(np.int64)
    known = np.searchsorted(s2_ns, s1_ns, side="right").astype(np.int64)
    return Made(Series(s1_ns, s1, s2_ns, s2, known), truth)


def _fast(generator: np.random.Generator, kind: Standin, time_s: Reals, truth: Reals) -> Reals:
    n, dt = time_s.size, float(time_s[1])
    if kind.noise < 0.0:
        return np.asarray(generator.standard_normal(n))
    since = np.maximum(time_s - (time_s[-1] / 2.0 if kind.late else 0.0), 0.0)
    begun = since > 0.0
    slope = kind.slope + kind.wander * np.cumsum(generator.standard_normal(n)) * dt**0.5
    bias = kind.bias + np.cumsum(np.where(begun, slope, 0.0)) * dt
    bias += kind.walk * np.cumsum(np.where(begun, generator.standard_normal(n), 0.0)) * dt**0.5
    speed = np.gradient(truth, dt)
    s1 = kind.scale * truth + bias + kind.slip * np.maximum(speed, 0.0)
    s1 += kind.strain * np.gradient(speed, dt) + kind.noise * generator.standard_normal(n)
    for begin in np.flatnonzero(generator.random(n) < kind.spikes):
        end = begin + generator.integers(1, kind.longest_spike + 1)
        size = generator.choice([-1.0, 1.0]) * np.exp(generator.uniform(-1.2, 1.2))
        s1[begin:end] += size * max(float(np.std(truth)), 0.3)
    return np.asarray(s1, np.float64)


def _slow(
    generator: np.random.Generator, kind: Standin, time_s: Reals, truth: Reals
) -> tuple[Reals, Reals]:
    dt = time_s[1]
    seen = truth
    if kind.window > 0.0:
        width = max(round(kind.window / dt), 1)
        padded = np.concatenate([np.full(width - 1, seen[0]), seen])
        seen = np.convolve(padded, np.full(width, 1.0 / width), mode="valid")
    for _ in range(kind.order if kind.lag > 0.0 else 0):
        seen = _low_pass(seen, dt, kind.lag)
    s2_s = np.arange(0.3, time_s[-1], 1.0 / kind.s2_hz)
    if kind.gaps[1] > 0.0:
        begin = 15.0
        while begin < time_s[-1]:
            end = begin + generator.uniform(*kind.gaps)
            s2_s = s2_s[(s2_s < begin) | (s2_s >= end)]
            begin = end + 10.0 + generator.exponential(25.0)
    delay = kind.delay * np.maximum(1.0 + kind.jitter * generator.standard_normal(s2_s.size), 0.0)
    s2 = np.interp(s2_s - delay, time_s, seen)
    s2 += kind.s2_noise * generator.standard_normal(s2.size)
    off = generator.random(s2.size) < kind.outliers
    s2[off] += generator.standard_normal(int(off.sum())) * 1.5 * np.std(truth)
    if kind.quantum > 0.0:
        s2 = np.round(s2 / kind.quantum) * kind.quantum
    return s2_s, s2


def _activity(generator: np.random.Generator, time_s: Reals, kind: Standin) -> Reals:
    """Return how much the signal moves, 0 to 1: now and then, mostly in the busy half."""
    active = np.zeros(time_s.size)
    now, moving = 0.0, False
    while now < time_s[-1]:
        first = now < time_s[-1] / 2.0
        calm = kind.busy != "both" and first != (kind.busy == "first")
        length = 2.0 + generator.exponential((3.0 if calm else 10.0) if moving else 8.0)
        size = generator.uniform(0.1, 0.4) if calm else generator.uniform(0.5, 1.0)
        active[(time_s >= now) & (time_s < now + length)] = size if moving else 0.0
        now, moving = now + length, not moving
    return _low_pass(active, time_s[1], 0.3)


def _turns(generator: np.random.Generator, time_s: Reals, active: Reals) -> Reals:
    turned = np.cumsum(active * _coloured(generator, time_s, 1.5, 0.5)) * time_s[1]
    return np.asarray(turned, np.float64)


def _swings(generator: np.random.Generator, time_s: Reals, active: Reals) -> Reals:
    hz = 0.5 + 0.3 * np.abs(_coloured(generator, time_s, 6.0, 1.0))
    size = active * (0.6 + _coloured(generator, time_s, 5.0, 0.2))
    swung = size * np.sin(2.0 * np.pi * np.cumsum(hz) * time_s[1])
    return _low_pass(swung + active * _coloured(generator, time_s, 4.0, 0.3), time_s[1], 0.05)


def _drives(generator: np.random.Generator, time_s: Reals, active: Reals) -> Reals:
    dt = time_s[1]
    wanted = np.zeros(time_s.size)
    now = 0.0
    while now < time_s[-1]:
        length = generator.uniform(4.0, 20.0)
        here = (time_s >= now) & (time_s < now + length)
        fast = 0.0 if generator.random() < 0.3 else generator.uniform(2.0, 15.0)
        wanted[here] = fast * (0.3 + 0.7 * float(active[here].mean()))
        now += length
    speed = np.zeros(time_s.size)
    pull = 0.0
    for k in range(1, speed.size):
        pull += (np.clip(0.8 * (wanted[k] - speed[k - 1]), -2.0, 2.0) - pull) * dt / 0.3
        speed[k] = max(0.0, speed[k - 1] + pull * dt)
    return speed


def _ranges(generator: np.random.Generator, time_s: Reals, active: Reals) -> Reals:
    moved = np.cumsum(active * _coloured(generator, time_s, 2.0, 0.5)) * time_s[1]
    return np.asarray(2.0 + moved - _low_pass(moved, time_s[1], 20.0), np.float64)


def _heats(generator: np.random.Generator, time_s: Reals, active: Reals) -> Reals:
    """Return the temperature of a block whose heater is on now and then, for minutes."""
    power = np.zeros(time_s.size)
    now = 0.0
    while now < time_s[-1]:
        length = generator.uniform(120.0, 1200.0)
        power[(time_s >= now) & (time_s < now + length)] = generator.choice([0.0, 0.5, 1.0])
        now += length
    return 20.0 + 80.0 * _low_pass(_low_pass(power, time_s[1], 60.0), time_s[1], 1500.0)


_MOTIONS = {
    "turns": _turns,
    "swings": _swings,
    "drives": _drives,
    "ranges": _ranges,
    "heats": _heats,
}


def _coloured(generator: np.random.Generator, time_s: Reals, memory: float, size: float) -> Reals:
    """Return noise that forgets itself in ``memory`` seconds, of standard deviation ``size``."""
    stay = float(np.exp(-time_s[1] / memory))
    fresh = size * (1.0 - stay**2) ** 0.5 * generator.standard_normal(time_s.size)
    return np.asarray(lfilter([1.0], [1.0, -stay], fresh), np.float64)


def _low_pass(values: Reals, dt: float, time_constant: float) -> Reals:
    stay = float(np.exp(-dt / time_constant))
    found, _ = lfilter([1.0 - stay], [1.0, -stay], values, zi=[stay * values[0]])
    return np.asarray(found, np.float64)
