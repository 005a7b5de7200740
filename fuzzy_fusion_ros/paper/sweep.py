# SPDX-License-Identifier: Apache-2.0
"""The sweeps of Figs 18-23: every method at every point, over the same seeds."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import (
    Flags,
    Reals,
    integral_absolute_error,
    integral_time_absolute_error,
    root_mean_square,
    seconds_since,
)
from fuzzy_fusion_ros.paper.methods import Contender
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario

SWEEPS: Mapping[str, tuple[float, ...]] = MappingProxyType(
    {
        "tau2": (0.05, 0.10, 0.15, 0.20, 0.25, 0.30),
        "sigma1": (0.02, 0.05, 0.10, 0.15),
        "bias1": (-0.10, -0.06, -0.03, 0.0, 0.03, 0.06, 0.10),
    }
)
"""What is swept, each around the nominal point: s, rad, rad."""

SETTLED = 5.0
"""From this time on a run has settled, seconds: the ideal loop's transient is long over."""

AFTERMATH = 0.4
"""S2 and the loop respond to the disturbance for this long, seconds: twice S2's lag."""

LAST = 10.0
"""Oscillation is judged over this last part of a run, or before a fall, seconds."""


class Point(NamedTuple):
    """A point of the sweeps: S2's time constant in s, S1's noise and bias in rad."""

    tau2: float
    sigma1: float
    bias1: float


class Outcome(NamedTuple):
    """Outcome of one run.

    Attributes:
        method: Name of the method.
        point: Where in the sweeps.
        seed: Seed of the run's generator.
        iae: Eq. (14), rad s.
        itae: Eq. (15), rad s^2.
        rmse: Root mean square of estimate less angle until a fall, rad.
        fell: Whether the pendulum fell.
        swing: How far it swung to *both* sides in the last 10 s, or before a fall, rad; below 0
            if to one side only.
        unrest: Largest angle from when it had settled to the disturbance, rad.
        signal: Root mean square of the angle until a fall, rad.
        s1_rmse: Root mean square of S1 less angle until a fall, rad.
        s1_offset: Mean of S1 less angle until a fall, rad.
        s2_rmse: Root mean square of S2 less angle until a fall, rad.
        rejected_pushed: Share of the predictions during the disturbance and its aftermath that
            the gate rejected, NaN if there were none.
        rejected_calm: The same from when it had settled to the disturbance.
    """

    method: str
    point: Point
    seed: int
    iae: float
    itae: float
    rmse: float
    fell: bool
    swing: float
    unrest: float
    signal: float
    s1_rmse: float
    s1_offset: float
    s2_rmse: float
    rejected_pushed: float
    rejected_calm: float


def point_of(scenario: Scenario) -> Point:
    """Return the point of the sweeps at which a scenario is."""
    return Point(
        tau2=scenario.s2_sensor.time_constant,
        sigma1=scenario.s1_sensor.noise,
        bias1=scenario.s1_sensor.bias,
    )


NOMINAL = point_of(Scenario())


def scenario_at(point: Point) -> Scenario:
    """Return the scenario at a point of the sweeps, the rest nominal."""
    changes = {
        "s2_sensor.time_constant": point.tau2,
        "s1_sensor.noise": point.sigma1,
        "s1_sensor.bias": point.bias1,
    }
    return replace(Scenario(), changes)


def sweep_points(swept: str) -> tuple[Point, ...]:
    """Return the points of one sweep, the swept quantity rising."""
    return tuple(NOMINAL._replace(**{swept: value}) for value in SWEEPS[swept])


def points_of(sweeps: Iterable[str]) -> tuple[Point, ...]:
    """Return the nominal point, then the others of the named sweeps, each once."""
    found = dict.fromkeys([NOMINAL])
    for swept in sweeps:
        found.update(dict.fromkeys(sweep_points(swept)))
    return tuple(found)


def simulate_at(contender: Contender, point: Point, seed: int) -> Run:
    """Run one method at one point; runs with the same seed have the same noise."""
    scenario = contender.with_its_sensors(scenario_at(point))
    return simulate(contender.method, scenario, np.random.default_rng(seed))


def sweep(
    contenders: Sequence[Contender], points: Sequence[Point], seeds: Sequence[int], jobs: int
) -> Iterator[Outcome]:
    """Run every method at every point with every seed, and yield the outcomes.

    The order and the outcomes do not depend on ``jobs``.

    Args:
        contenders: The methods.
        points: Points of the sweeps.
        seeds: Seeds, the same for every method and point.
        jobs: Number of threads.
    """
    todo = [(each, point, seed) for point in points for seed in seeds for each in contenders]
    pool = ThreadPoolExecutor(jobs)
    try:
        yield from pool.map(lambda run: _outcome(*run), todo)
    finally:
        pool.shutdown(cancel_futures=True)


def _outcome(contender: Contender, point: Point, seed: int) -> Outcome:
    return outcome_of(contender.name, point, seed, simulate_at(contender, point, seed))


def outcome_of(method: str, point: Point, seed: int, run: Run) -> Outcome:
    """Return the outcome of a run."""
    scenario = scenario_at(point)
    push = scenario.disturbance
    t = elapsed(run)
    angle = np.abs(run.truth)
    alive = slice(run.survived)
    truth = run.truth[alive]
    calm = _between(t, SETTLED, push.start)
    end = truth[-round(LAST / scenario.sample_time) :]
    return Outcome(
        method=method,
        point=point,
        seed=seed,
        iae=integral_absolute_error(t, run.truth),
        itae=integral_time_absolute_error(t, run.truth),
        rmse=root_mean_square(run.trace.value[alive] - truth),
        fell=run.survived < run.truth.size,
        swing=float(min(np.max(end), -np.min(end))),
        unrest=float(np.max(angle[calm])),
        signal=root_mean_square(truth),
        s1_rmse=root_mean_square(run.s1[alive] - truth),
        s1_offset=float(np.mean(run.s1[alive] - truth)),
        s2_rmse=root_mean_square(run.s2[alive] - truth),
        rejected_pushed=_rejected(run, _between(t, push.start, push.end + AFTERMATH)),
        rejected_calm=_rejected(run, calm),
    )


def elapsed(run: Run) -> Reals:
    """Return the time of each sample, seconds from the first."""
    return seconds_since(run.stamps_ns[0], run.stamps_ns)


def _between(t: Reals, start: float, end: float) -> Flags:
    """Mark the samples of a half-open span; rounding does not move one across its edge."""
    tiny = 1e-9
    return (t >= start - tiny) & (t < end - tiny)


def _rejected(run: Run, span: Flags) -> float:
    predicted = run.trace.predicted & span
    if not predicted.any():
        return float("nan")
    return float(np.mean(~run.trace.accepted[predicted]))
