# SPDX-License-Identifier: Apache-2.0
"""Prints the table of docs/sensors.md: rates as S1 on two real recordings, and other filters.

    python docs/compare_rates.py FOLDER

The folder holds car_raw.csv, car_raw_gnss.csv and broad_raw.csv, extracted from the recordings that
the page names. Every filter is tuned on the first half and scored on the second. VQF needs the
package of that name (pip install vqf), and is left out without it.
"""

from __future__ import annotations

import functools
import importlib
import itertools
import math
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros import Topics, score, tune
from fuzzy_fusion_ros.bag import BagWriter
from fuzzy_fusion_ros.batch.arrays import Reals, nearest, root_mean_square
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec, default_message
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

TURN = 2.0 * math.pi
BEGIN_NS = 1_700_000_000_000_000_000
SCALAR = "geometry_msgs/msg/PointStamped"
MOVING = 1.5
"""Speed in m/s below which the course of a receiver is meaningless."""

GRAVITY = 9.81
SHOWN = ("complementary", "kalman_bias")
"""Baselines with a column of their own."""


class Signal(NamedTuple):
    """What is fused, at the times of each sensor; NaN where there is none.

    Attributes:
        period: ``signal.period``.
        s1_s, s2_s: Times, seconds.
        rate: S1, the rate.
        s2: S2.
        truth: What S2 measures, at the times of S1.
    """

    period: float
    s1_s: Reals
    s2_s: Reals
    rate: Reals
    s2: Reals
    truth: Reals

    @property
    def middle(self) -> float:
        """Where the second half begins, seconds."""
        return 0.5 * float(self.s1_s[-1])


def main() -> None:
    """Print the table, then the errors of the filters of all three axes."""
    folder = Path(sys.argv[1])
    print(
        "| signal | S1 integrated beforehand | as a rate, same parameters | "
        "as a rate, tuned as a rate | complementary | "
        "Kalman with bias state | best of all filters in `score` |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, signal in (*_car(folder), *_imu(folder)):
        integrated, tuned = _scores(signal, "value")
        same, _ = _scores(signal, "rate", replace(tuned, {"s1.kind": "rate"}))
        rates, _ = _scores(signal, "rate")
        ours = rates.pop("estimate")
        best = min(rates, key=rates.__getitem__)
        errors = [integrated["estimate"], same["estimate"], ours]
        errors += [*(rates[each] for each in SHOWN), rates[best]]
        print(f"| {name} | {' | '.join(_cells(errors))} `{best}` |", flush=True)
    for name, (roll, pitch) in _attitudes(folder):
        print(f"{name}: roll {roll:.2g} rad, pitch {pitch:.2g} rad", flush=True)


def _cells(errors: Sequence[float]) -> list[str]:
    """Return errors to three digits, the smallest one in bold."""
    texts = [f"{each:#.3g}" for each in errors]
    return [
        f"**{text}**" if each == min(errors) else text
        for text, each in zip(texts, errors, strict=True)
    ]


def _scores(
    signal: Signal, kind: str, given: Parameters | None = None
) -> tuple[dict[str, float], Parameters]:
    """Return the RMSE on the second half, and the parameters: given, or tuned on the first half."""
    first = nearest(signal.s2[:1], signal.truth[0], signal.period)[0]
    steps = 0.5 * (signal.rate[1:] + signal.rate[:-1]) * np.diff(signal.s1_s)
    integral = first + np.append(0.0, np.cumsum(steps))
    s1 = signal.rate if kind == "rate" else nearest(integral, 0.0, signal.period)
    parameters = replace(Parameters(), {"signal.period": signal.period, "s1.kind": kind})
    with tempfile.TemporaryDirectory() as folder:
        bag, tuned = Path(folder) / "bag", Path(folder) / "tuned.yaml"
        tracks = {
            "/truth": (signal.s1_s, signal.truth),
            "/s2": (signal.s2_s, signal.s2),
            "/s1": (signal.s1_s, s1),
        }
        _write(bag, tracks)
        if given is None:
            given = tune(bag, tuned, parameters=parameters, end=signal.middle).parameters
            found = score(bag, parameters=tuned, start=signal.middle, topics=Topics())
        else:
            found = score(bag, parameters=given, start=signal.middle, topics=Topics())
    return {name: found.scores(name)["rmse"] for name in found.values}, given


def _write(path: Path, tracks: dict[str, tuple[Reals, Reals]]) -> None:
    types = InstalledTypes()
    codec = ScalarCodec(types, SCALAR)
    template = codec.template(default_message(types, SCALAR))
    samples = sorted(
        (float(time_s), place, topic, float(value))
        for place, (topic, track) in enumerate(tracks.items())
        for time_s, value in zip(*track, strict=True)
        if math.isfinite(value)
    )
    with BagWriter(path) as writer:
        for time_s, _, topic, value in samples:
            stamp_ns = BEGIN_NS + round(time_s * 1e9)
            writer.write(topic, SCALAR, stamp_ns, template.filled(value, stamp_ns))


def _car(folder: Path) -> Iterator[tuple[str, Signal]]:
    imu, gnss = (_columns(folder / f"{each}.csv") for each in ("car_raw", "car_raw_gnss"))
    speed = np.hypot(gnss["vn"], gnss["ve"])
    moving = speed > MOVING
    yield (
        "car, heading from gyro and course, rad",
        Signal(
            TURN, imu["t"], gnss["t"][moving], imu["wz"], gnss["course"][moving], imu["ref_yaw"]
        ),
    )
    yield (
        "car, speed from accelerometer and GNSS, m/s",
        Signal(0.0, imu["t"], gnss["t"], imu["ax"], speed, imu["ref_speed"]),
    )


def _imu(folder: Path) -> Iterator[tuple[str, Signal]]:
    imu = _columns(folder / "broad_raw.csv")
    roll = np.arctan2(imu["ay"], imu["az"])
    pitch = np.arctan2(-imu["ax"], np.hypot(imu["ay"], imu["az"]))
    truth = _angles(*(imu[f"ref_q{each}"] for each in "wxyz"))
    times = imu["t"], imu["t"]
    yield "IMU by hand, pitch, rad", Signal(0.0, *times, imu["wy"], pitch, truth[1])
    yield "IMU by hand, roll, rad", Signal(TURN, *times, imu["wx"], roll, truth[0])


def _attitudes(folder: Path) -> Iterator[tuple[str, list[float]]]:
    """Yield filters of all three axes, each tuned on the first half, and their errors."""
    imu = _columns(folder / "broad_raw.csv")
    gyro, accel = (np.column_stack([imu[f"{each}{k}"] for k in "xyz"]) for each in "wa")
    truth = _angles(*(imu[f"ref_q{each}"] for each in "wxyz"))
    first = imu["t"] < 0.5 * imu["t"][-1]

    def errors(found: Sequence[Reals], where: Reals) -> list[float]:
        usable = where & np.isfinite(truth[0])
        return [
            float(root_mean_square(nearest(one - other, 0.0, TURN)[usable]))
            for one, other in zip(found, truth, strict=True)
        ]

    def tuned(runs: Sequence[Callable[[], Sequence[Reals]]]) -> list[float]:
        best = min((run() for run in runs), key=lambda found: sum(errors(found, first)))
        return errors(best, ~first)

    gains = itertools.product((1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2), (False, True), (False, True))
    filters = [functools.partial(_valenti, imu["t"], gyro, accel, *each) for each in gains]
    yield "imu_complementary_filter", tuned(filters)
    try:
        vqf = importlib.import_module("vqf").VQF
    except ImportError:
        return
    step = float(np.median(np.diff(imu["t"])))

    def attitude(time_constant: float) -> Sequence[Reals]:
        found = vqf(step, tauAcc=time_constant).updateBatch(gyro, accel)
        return _angles(*found["quat6D"].T)

    time_constants = (0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0, 80.0)
    yield "VQF", tuned([functools.partial(attitude, each) for each in time_constants])


def _valenti(
    time_s: Reals, gyro: Reals, accel: Reals, gain: float, is_adaptive: bool, has_bias: bool
) -> Sequence[Reals]:
    """Return roll and pitch as imu_complementary_filter computes them (Valenti et al., 2015)."""
    q = _towards(accel[0] / np.linalg.norm(accel[0]))
    bias, before, found = np.zeros(3), np.zeros(3), [q]
    for k in range(1, time_s.size):
        size = float(np.linalg.norm(accel[k]))
        is_steady = abs(size - GRAVITY) < 0.1 and np.all(np.abs(gyro[k] - before) < 0.01)
        if has_bias and is_steady and np.all(np.abs(gyro[k] - bias) < 0.2):
            bias = bias + 0.01 * (gyro[k] - bias)
        before = gyro[k]
        turned = np.append(0.0, gyro[k] - bias) * 0.5 * (time_s[k] - time_s[k - 1])
        q = q + _product(_conjugate(turned), q)
        q = q / np.linalg.norm(q)
        seen = _rotated(_conjugate(q), accel[k] / size)
        off = abs(size - GRAVITY) / GRAVITY
        share = gain * (float(np.clip(2.0 - 10.0 * off, 0.0, 1.0)) if is_adaptive else 1.0)
        q = _product(q, _part(_towards(seen), share))
        q = q / np.linalg.norm(q)
        found.append(q)
    return _angles(*_conjugate(np.array(found).T))


def _towards(up: Reals) -> Reals:
    """Return the rotation from the direction of gravity in the world to one in the body."""
    size = math.sqrt(max(0.5 * (float(up[2]) + 1.0), 1e-9))
    return np.array([size, -up[1] / (2.0 * size), up[0] / (2.0 * size), 0.0])


def _part(q: Reals, share: float) -> Reals:
    part = share * q + (1.0 - share) * np.array([1.0, 0.0, 0.0, 0.0])
    return np.asarray(part / np.linalg.norm(part))


def _conjugate(q: Reals) -> Reals:
    return np.concatenate([q[:1], -q[1:]])


def _product(p: Reals, q: Reals) -> Reals:
    real = p[0] * q[0] - p[1:] @ q[1:]
    return np.append(real, p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))


def _rotated(q: Reals, vector: Reals) -> Reals:
    return _product(_product(q, np.append(0.0, vector)), _conjugate(q))[1:]


def _angles(w: Reals, x: Reals, y: Reals, z: Reals) -> list[Reals]:
    """Return roll and pitch of quaternions."""
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return [roll, np.arcsin(np.clip(2.0 * (w * y - z * x), -1.0, 1.0))]


def _columns(path: Path) -> dict[str, Reals]:
    table = np.genfromtxt(path, delimiter=",", names=True)
    return {name: np.asarray(table[name], np.float64) for name in table.dtype.names or ()}


if __name__ == "__main__":
    main()
