# SPDX-License-Identifier: Apache-2.0
"""Values of one sensor: not finite, wrapping, with spikes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from checking.made import START_NS, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.samples import two_sensors
from fuzzy_fusion_ros.checking.values import judge_values, outliers_of, spikes_of, wrap_of
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

TIMES: Reals = 0.01 * np.arange(3000)
NOISE: Reals = np.random.default_rng(0).normal(size=3000)
TURN = 2.0 * math.pi


def wrapped(angle: Reals, period: float) -> Reals:
    """Return an angle in (-period / 2, period / 2]."""
    found: Reals = angle - period * np.ceil(angle / period - 0.5)
    return found


@pytest.mark.parametrize("period", [TURN, 360.0])
@pytest.mark.parametrize("from_zero", [False, True])
def test_an_angle_that_wraps(period: float, from_zero: bool) -> None:
    angle = period * (TIMES / 7.0 + 0.01 * NOISE)
    values = angle % period if from_zero else wrapped(angle, period)
    found = wrap_of(values)
    assert found.period == period
    assert found.jumps >= 4
    unwrapped = found.unwrapped(values)
    assert unwrapped - unwrapped[0] == pytest.approx(angle - angle[0], abs=1e-9 * period)


@pytest.mark.parametrize(
    "values",
    [
        3.0 * np.sin(TIMES),
        TURN * np.sign(np.sin(TIMES)),  # jumps by two turns
        2.0 * NOISE,
        np.where(TIMES < 15.0, 0.0, TURN),  # one jump, from rest to rest
        100.0 * TIMES,
        np.zeros(3000),
        np.zeros(1),
    ],
)
def test_what_does_not_wrap(values: Reals) -> None:
    assert wrap_of(values).jumps == (1 if values.max() == TURN and values.min() == 0.0 else 0)


def test_a_wrap_is_named_with_its_period() -> None:
    samples = sensor("s2", TIMES, wrapped(TIMES, 360.0 / 100.0) * 100.0)
    finding = only(judge_values(samples, 0.0).findings, "wrap")
    assert finding.text == "s2 wraps: it jumps by 360 degrees, 8 times"
    assert finding.remedy == "signal.period: 360"
    assert finding.level is Level.WARNING


def test_the_other_sensors_period_is_used() -> None:
    values = np.array([3.0, -3.0, 3.0] * 20)
    assert np.ptp(judge_values(sensor("s1", TIMES[:60], values), TURN).clean) < 1.0


@pytest.mark.parametrize("share", [0.01, 0.02, 0.1])
def test_spikes(share: float) -> None:
    generator = np.random.default_rng(1)
    where = generator.uniform(size=3000) < share
    clean = np.sin(TIMES) + 0.1 * NOISE
    found = spikes_of(clean + np.where(where, generator.choice([-5.0, 5.0], 3000), 0.0))
    assert np.mean(found[where]) > 0.9
    assert np.mean(found[~where]) < 2e-3


@pytest.mark.parametrize(
    "values",
    [
        NOISE,
        np.sin(20.0 * TIMES),
        np.round(np.sin(TIMES), 1),  # coarse
        np.floor(TIMES),  # steps
        np.repeat(NOISE[:300], 10),  # held
        np.where(NOISE > 0.0, 1.0, 0.0),
        np.zeros(3000),
        np.append(np.zeros(1500), NOISE[:1500]),
        np.arange(5.0),
    ],
)
def test_what_is_no_spike(values: Reals) -> None:
    assert np.count_nonzero(spikes_of(values)) == 0


@pytest.mark.parametrize(
    ("count", "level", "remedy"),
    [(6, Level.INFO, ""), (60, Level.WARNING, "s1.spike_threshold: 2.5")],
)
def test_many_spikes_are_a_fault(count: int, level: Level, remedy: str) -> None:
    values = 0.1 * NOISE
    values[np.linspace(20, 2900, count).astype(int)] += 5.0
    finding = only(judge_values(sensor("s1", TIMES, values), 0.0).findings, "spikes")
    assert (finding.level, finding.remedy) == (level, remedy)
    assert finding.text.startswith(f"s1 has spikes: {count} of 3000 samples")


@pytest.mark.parametrize("where", [[1234], [0], [5, 6, 7, 8, 9], [0, 700, 1400, 2100, 2999]])
@pytest.mark.parametrize("garbage", [1e3, -1e5])
def test_single_samples_of_garbage_are_named_and_left_out(where: list[int], garbage: float) -> None:
    values = np.sin(TIMES)
    values[where] = garbage
    found = judge_values(sensor("s1", TIMES, values), 0.0, start_ns=START_NS)
    (finding,) = found.findings
    assert finding.about == "outliers"
    assert finding.level is Level.WARNING
    assert finding.text == (
        f"s1 has outliers: {len(where)} of 3000 samples, up to {garbage:.3g}, over 30 times as far "
        f"from the median as any other, the first at {0.01 * where[0]:.1f} s"
    )
    assert finding.remedy.startswith("s1.spike_threshold: 3")
    assert found.spikes == 0.0
    assert found.clean == pytest.approx(np.sin(TIMES), abs=0.1)


def test_a_limit_for_a_rate_is_one_for_its_integral() -> None:
    values = np.cos(TIMES)
    values[100] = 1e5
    finding = only(
        judge_values(sensor("s1", TIMES, values), 0.0, is_rate=True).findings, "outliers"
    )
    assert float(finding.remedy.removeprefix("s1.spike_threshold: ")) == pytest.approx(0.03, 0.1)
    of_s2 = only(judge_values(sensor("s2", TIMES, values), 0.0).findings, "outliers")
    assert of_s2.remedy.startswith("s2.outlier_threshold: 4, which needs s1.bias_time_constant > 0")


@pytest.mark.parametrize("spiky", [False, True])
@pytest.mark.parametrize("kind", ["value", "rate"])
def test_what_is_set_to_reject_them_is_told_from_what_lets_them_pass(
    spiky: bool, kind: str
) -> None:
    values = 0.1 * NOISE
    values[np.arange(20, 2900, 40) if spiky else [1234]] += 5.0 if spiky else 1e5
    s1, s2 = (sensor(name, TIMES, values) for name in ("s1", "s2"))
    about = "spikes" if spiky else "outliers"

    def judged(parameters: dict[str, float]) -> list[Finding]:
        given = replace(Parameters(), {"s1.kind": kind, **parameters})
        return [
            only(judge_values(each, 0.0, is_rate=kind == "rate").findings, about)
            for each in two_sensors(s1, s2, START_NS, given)[:2]
        ]

    of_s1, _ = judged({})
    assert of_s1.level is Level.WARNING
    name, proposed = of_s1.remedy.split(": ")
    for factor, level in ((1.0, Level.INFO), (1.5, Level.INFO), (100.0, Level.WARNING)):
        of_s1, of_s2 = judged({name: factor * float(proposed)})
        assert (of_s1.level, of_s2.level) == (level, Level.WARNING)
    of_s1, of_s2 = judged({"s2.outlier_threshold": 4.0})
    assert (of_s1.level, of_s2.level) == (Level.WARNING, Level.WARNING)  # it needs the observer
    of_s1, of_s2 = judged({"s2.outlier_threshold": 4.0, "s1.bias_time_constant": 1.0})
    assert (of_s1.level, of_s2.level) == (Level.WARNING, Level.INFO)
    assert of_s2.text.endswith("; handled by s2.outlier_threshold: 4")
    assert of_s2.remedy == ""


@pytest.mark.parametrize(("n", "garbage"), [(5, 1e5), (30, 1e4), (150, 1e5), (199, -300.0)])
@pytest.mark.parametrize("place", [0.0, 0.3, 0.9])
def test_a_single_value_of_garbage_is_named_among_few_samples(
    n: int, garbage: float, place: float
) -> None:
    values = np.sin(7.0 * TIMES[:n]) + 10.0
    at = int(place * (n - 1))
    values[at] = garbage
    found = judge_values(sensor("s2", TIMES[:n], values), 0.0)
    assert only(found.findings, "outliers").text.startswith(f"s2 has outliers: 1 of {n} samples")
    assert abs(found.clean[at]) < 12.0


@pytest.mark.parametrize("n", [5, 30, 150, 1000, 3000])
@pytest.mark.parametrize("last", [1, 2, 3, 5])
def test_a_step_of_a_resting_sensor_at_the_end_may_last(n: int, last: int) -> None:
    values = 1e-3 * NOISE[:n]
    values[n - last :] += 10.0
    found = outliers_of(values)
    assert not (found.which & ~found.last).any()
    if n > 5:
        values[n // 4] = 1e4
        found = outliers_of(values)
        assert np.flatnonzero(found.which & ~found.last).tolist() == [n // 4]


def test_garbage_at_the_end_is_left_out_of_the_comparison() -> None:
    values = 0.1 * NOISE
    values[-1] = 1e6
    found = judge_values(sensor("s2", TIMES, values), 0.0)
    assert only(found.findings, "last samples").level is Level.INFO
    assert abs(found.clean[-1]) < 1.0


@pytest.mark.parametrize("n", [150, 199, 399])
def test_a_movement_of_a_few_samples_is_no_outlier(n: int) -> None:
    values = 1e-3 * NOISE[:n]
    values[60:62] = 1.0  # there and back
    assert not outliers_of(values).which.any()


@pytest.mark.parametrize(
    "values",
    [
        NOISE,
        NOISE**9,  # heavy tails
        np.where(TIMES < 29.9, 1e-3 * NOISE, TIMES - 29.9),  # a movement from rest
        np.where(TIMES < 29.97, 0.0, 1.0),  # exactly at rest
        np.where(np.arange(3000) % 100 == 0, 1e3, NOISE),  # many
        np.append(NOISE[:50], 1e5),  # it may stay
        np.append(NOISE, 1e5),
        np.array([0.0, 0.0, 9.0, 0.0]),  # two levels
        np.array([1.0, 2.0]),
        np.zeros(3000),
        np.zeros(0),
    ],
)
def test_what_is_no_outlier(values: Reals) -> None:
    found = outliers_of(values)
    assert not (found.which & ~found.last).any()


def test_values_that_are_not_finite() -> None:
    values = NOISE.copy()
    values[[5, 6, 7]] = math.nan, math.inf, -math.inf
    found = judge_values(sensor("s1", TIMES, values), 0.0)
    assert only(found.findings, "not finite").text == (
        "3 of 3000 samples of s1 are dropped: value is not finite"
    )
    assert found.clean.size == 2997
