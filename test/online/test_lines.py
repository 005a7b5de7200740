# SPDX-License-Identifier: Apache-2.0
"""Angles that wrap and rates that are integrated, in front of the fusion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fuzzy_fusion_ros.batch import arrays
from fuzzy_fusion_ros.core.periodic import nearest
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.lines import EARLY, Integrated, Unwrapped
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

TURN = 2.0 * math.pi
SECOND = 1_000_000_000
CONDITIONED = {
    "s1.lowpass_time_constant": 0.05,
    "s1.bias_time_constant": 2.0,
    "predictor.enabled": True,
    "predictor.samples": 5,
}


def parameters(period: float = TURN, **changes: object) -> Parameters:
    return replace(Parameters(), {"signal.period": period, **changes})


Row = tuple[int, str, float]


def rows(rate: float, seconds: float = 8.0, offset: float = 0.3, wraps: bool = True) -> list[Row]:
    """S1 at 50 Hz, off by an offset, and S2 at 5 Hz of a heading that turns at a rate."""
    found = []
    for k in range(round(50 * seconds)):
        time_s = 0.02 * k
        heading = rate * time_s + 0.2 * math.sin(3.0 * time_s)
        samples = [("s1", heading + offset + 0.02 * math.sin(91.0 * time_s))]
        if k % 10 == 0:
            samples.insert(0, ("s2", heading))
        for name, value in samples:
            wrapped = nearest(value, 0.0, TURN) if wraps else value
            found.append((SECOND + round(time_s * SECOND), name, wrapped))
    return found


def estimates(
    given_rows: list[Row], chosen: Parameters
) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    fusion = Fusion(chosen)
    found = []
    for stamp_ns, name, value in given_rows:
        on_sample = fusion.on_s1 if name == "s1" else fusion.on_s2
        found += [each.estimate.value for each in on_sample(Sample(stamp_ns, value)).estimates]
    return np.array(found)


@pytest.mark.parametrize("changes", [{}, CONDITIONED])
def test_a_signal_that_never_wraps_gives_the_same_to_the_bit(changes: dict[str, object]) -> None:
    calm = rows(0.0)
    with_period = estimates(calm, parameters(**changes))
    assert with_period.size == 400
    assert np.array_equal(with_period, estimates(calm, parameters(0.0, **changes)))


@pytest.mark.parametrize("changes", [{}, CONDITIONED, {"trigger": "pair"}])
@given(turns=st.lists(st.integers(-3, 3), min_size=441, max_size=441))
@examples(10)
def test_full_turns_of_any_sample_change_nothing(
    changes: dict[str, object], turns: list[int]
) -> None:
    plain = rows(0.8)
    turned = [
        (stamp_ns, name, value + TURN * turn)
        for (stamp_ns, name, value), turn in zip(plain, turns, strict=False)
    ]
    chosen = parameters(**changes)
    difference = estimates(turned, chosen) - estimates(plain[: len(turned)], chosen)
    assert difference.size
    assert np.abs(arrays.nearest(difference, 0.0, TURN)).max() < 1e-9


@pytest.mark.parametrize("changes", [{}, CONDITIONED])
@pytest.mark.parametrize("rate", [0.8, -2.5])
def test_a_heading_that_turns_is_fused_as_if_it_did_not_wrap(
    changes: dict[str, object], rate: float
) -> None:
    found = estimates(rows(rate), parameters(**changes))
    line = estimates(rows(rate, wraps=False), parameters(0.0, **changes))
    assert (found > -0.5 * TURN).all()
    assert (found <= 0.5 * TURN).all()
    assert np.abs(arrays.nearest(found - line, 0.0, TURN)).max() < 1e-9


def test_spikes_that_are_rejected_add_no_turns() -> None:
    """Two in a row can, and then all that follow are a turn away from where S1 was."""
    chosen = {**CONDITIONED, "s1.spike_threshold": 0.5, "s2.delay": 0.3, "s2.noise": 0.02}
    rng = np.random.default_rng(1)
    is_spike = rng.random(5000) < 0.1
    spikes = np.where(is_spike, rng.uniform(-math.pi, math.pi, 5000), 0.0)
    line = [
        (stamp_ns, name, value + (float(spikes[k]) if name == "s1" else 0.0))
        for k, (stamp_ns, name, value) in enumerate(rows(3.0, 60.0, wraps=False))
    ]
    wrapped = [(stamp_ns, name, nearest(value, 0.0, TURN)) for stamp_ns, name, value in line]
    found = estimates(wrapped, parameters(**chosen))
    expected = estimates(line, parameters(0.0, **chosen))
    assert np.abs(arrays.nearest(found - expected, 0.0, TURN)).max() < 1e-9


def test_outliers_of_s2_add_no_turns() -> None:
    chosen = {**CONDITIONED, "s2.outlier_threshold": 4.0, "s2.noise": 0.05}
    rng = np.random.default_rng(1)
    is_outlier = rng.random(20_000) < 0.1
    outliers = np.where(is_outlier, rng.uniform(-2.8, 2.8, 20_000), 0.0)
    line = [
        (stamp_ns, name, value + (float(outliers[k]) if name == "s2" else 0.0))
        for k, (stamp_ns, name, value) in enumerate(rows(3.0, 120.0, wraps=False))
    ]
    wrapped = [(stamp_ns, name, nearest(value, 0.0, TURN)) for stamp_ns, name, value in line]
    found = estimates(wrapped, parameters(**chosen))
    expected = estimates(line, parameters(0.0, **chosen))
    assert np.abs(arrays.nearest(found - expected, 0.0, TURN)).max() < 1e-9


@pytest.mark.parametrize("kind", ["value", "rate"])
def test_s2_is_placed_by_where_s1_was_when_it_was_measured(kind: str) -> None:
    """It swings by more than half a turn within its age of 0.6 s and from one to the next."""
    changes = {"s1.kind": kind, "s1.bias_time_constant": 3.0, "s2.delay": 0.6, "s2.noise": 0.05}
    found = []
    for period in (TURN, 0.0):
        said, fusion = [], Fusion(parameters(period, **changes))
        for k in range(4000):
            time_s, stamp_ns = 0.02 * k, SECOND + k * 20_000_000
            heading, late = (3.0 * math.sin(2.0 * at) for at in (time_s, time_s - 0.6))
            s1 = heading + 0.1 if kind == "value" else 6.0 * math.cos(2.0 * time_s)
            if period > 0.0:
                late = nearest(late, 0.0, TURN)
                s1 = nearest(s1, 0.0, TURN) if kind == "value" else s1
            if k % 50 == 0:
                fusion.on_s2(Sample(stamp_ns, late))
            verdict = fusion.on_s1(Sample(stamp_ns, s1))
            said += [each.estimate.value - heading for each in verdict.estimates]
        found.append(arrays.nearest(np.array(said), 0.0, TURN))
    settled = slice(2500, None)  # at first there is no past of S1
    assert np.abs(found[0] - found[1])[settled].max() < 1e-6
    assert np.abs(found[0][settled]).max() < 0.3


@pytest.mark.parametrize("silent", ["s1", "s2"])
def test_after_a_silence_of_several_turns_the_sensors_agree_again(silent: str) -> None:
    def heard(wraps: bool) -> list[Row]:
        made = rows(1.8, 20.0, 0.1, wraps)
        return [each for each in made if each[1] != silent or not 4.0 < each[0] / 1e9 < 13.0]

    found = estimates(heard(wraps=True), parameters())
    line = estimates(heard(wraps=False), parameters(0.0))
    assert np.abs(arrays.nearest(found - line, 0.0, TURN)).max() < 1e-9


@pytest.mark.parametrize("seed", range(10))
def test_a_course_that_is_random_at_standstill_stays_on_its_turn(seed: int) -> None:
    generator = np.random.default_rng(seed)
    lines = Unwrapped(parameters())
    lines.on_s2(Sample(SECOND, 0.0))
    for k in range(1, 120):
        stamp_ns = SECOND + k * SECOND
        lines.on_s1(Sample(stamp_ns, 0.0))
        course = 0.0 if k > 100 else generator.uniform(-math.pi, math.pi)
        on_line = lines.on_s2(Sample(stamp_ns, course)).value
        assert abs(on_line) < TURN
    assert on_line == 0.0


def test_a_new_timeline_starts_new_lines() -> None:
    fusion = Fusion(parameters())
    for stamp_ns, name, value in [*rows(0.8), *rows(0.8)]:
        on_sample = fusion.on_s1 if name == "s1" else fusion.on_s2
        verdict = on_sample(Sample(stamp_ns, value))
    assert fusion.restarts == 1
    assert verdict.estimates[-1].estimate.value == estimates(rows(0.8), parameters())[-1]


@given(st.floats(-1e150, 1e150), st.floats(-1e150, 1e150))
def test_what_is_nearest_is_finite_and_the_same_for_arrays(value: float, reference: float) -> None:
    found = nearest(value, reference, TURN)
    assert math.isfinite(found)
    if max(abs(value), abs(reference)) < 1e9:
        assert abs(found - reference) <= 0.5 * TURN * (1 + 1e-6) + 1e-6
        array = arrays.nearest(np.array([value]), np.array([reference]), TURN)
        assert array[0] == found


def test_half_a_turn_is_positive() -> None:
    assert nearest(math.pi, 0.0, TURN) == math.pi
    assert nearest(-math.pi, 0.0, TURN) == math.pi
    assert nearest(180.0, 0.0, 360.0) == 180.0


def test_arrays_are_unwrapped() -> None:
    line = np.cumsum(np.random.default_rng(0).uniform(-2.0, 2.5, 200))
    assert arrays.unwrapped(arrays.nearest(line, line[0], TURN), TURN) == pytest.approx(line)
    assert arrays.unwrapped(line, 0.0) is line


def rate_rows(wraps: bool, bias: float = 0.02) -> tuple[list[Row], list[Row]]:
    """Return S1 as a rate, and as its integral from the first S2 on; both with the same S2."""
    plain = rows(0.8, offset=0.0, wraps=wraps)
    rates, values = [], []
    line, last = plain[0][2], 0.0
    for stamp_ns, name, value in plain:
        time_s = (stamp_ns - SECOND) * 1e-9
        if name == "s2":
            rates.append((stamp_ns, name, value))
            values.append((stamp_ns, name, value))
            continue
        rate = 0.8 + 0.6 * math.cos(3.0 * time_s) + bias
        if rates[-1][0] != stamp_ns or len(rates) > 1:
            line += 0.02 * (0.5 * last + 0.5 * rate)
        last = rate
        rates.append((stamp_ns, name, rate))
        values.append((stamp_ns, name, nearest(line, 0.0, TURN) if wraps else line))
    return rates, values


@pytest.mark.parametrize("changes", [{}, CONDITIONED])
@pytest.mark.parametrize("period", [0.0, TURN])
def test_a_rate_is_fused_as_its_integral(changes: dict[str, object], period: float) -> None:
    rates, values = rate_rows(wraps=period > 0.0)
    found = estimates(rates, parameters(period, **{"s1.kind": "rate", **changes}))
    outside = estimates(values, parameters(period, **changes))
    assert found.size == 400
    assert np.abs(arrays.nearest(found - outside, 0.0, TURN)).max() < 1e-9


def test_a_rate_has_no_value_before_s2_has_spoken() -> None:
    fusion = Fusion(parameters(0.0, **{"s1.kind": "rate"}))
    for k in range(1000):
        verdict = fusion.on_s1(Sample(SECOND + k * SECOND // 50, 1.0))
        assert (verdict.admitted, verdict.estimates) == (1, ())
    assert fusion.on_s2(Sample(SECOND + 20 * SECOND, 5.0)).estimates == ()
    (fused,) = fusion.on_s1(Sample(SECOND + 20 * SECOND, 1.0)).estimates
    assert fused.estimate.value == pytest.approx(5.0, abs=0.02)  # S1 moves by that much a sample


@pytest.mark.parametrize("period", [0.0, TURN])
@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_what_a_rate_has_measured_before_s2_counts(period: float, trigger: str) -> None:
    """S2 is behind, so its first sample says where S1 was before."""
    chosen = parameters(
        period,
        trigger=trigger,
        **{"s1.bias_time_constant": 2.0, "s2.delay": 0.4, "s2.lag_time_constant": 0.1},
    )
    rates, values = (
        [each for each in some if each[1] == "s1" or each[0] > 2 * SECOND]
        for some in rate_rows(wraps=period > 0.0)
    )
    place = next(k for k, each in enumerate(values) if each[1] == "s2")
    offset = values[place][2] - values[place - 1][2]
    values = [(ns, name, value + offset * (name == "s1")) for ns, name, value in values]
    found = estimates(rates, replace(chosen, {"s1.kind": "rate"}))
    assert found.size == (340 if trigger == "s1" else 34)
    assert np.abs(arrays.nearest(found - estimates(values, chosen), 0.0, TURN)).max() < 1e-9


def test_what_a_rate_has_measured_before_a_gap_does_not() -> None:
    lines = Integrated(parameters(0.0, **{"s1.kind": "rate"}))
    for k in (*range(100), *range(300, 310)):
        assert lines.on_s1(Sample(SECOND + k * SECOND // 50, 1.0)) is None
    lines.on_s2(Sample(SECOND + 309 * SECOND // 50, 5.0))
    early = lines.early()
    assert [each.value for each in early] == pytest.approx([5.0 + 0.02 * k for k in range(-9, 1)])
    assert lines.early() == ()


def test_of_a_rate_that_waits_for_long_only_the_newest_samples_are_kept() -> None:
    lines = Integrated(parameters(0.0, **{"s1.kind": "rate"}))
    for k in range(2 * EARLY):
        lines.on_s1(Sample(SECOND + k * SECOND // 50, 1.0))
    lines.on_s2(Sample(SECOND + 2 * EARLY * SECOND // 50, 5.0))
    early = lines.early()
    assert len(early) == EARLY
    assert early[-1].value == pytest.approx(5.0)


def test_over_a_gap_a_rate_moves_as_s2_has() -> None:
    lines = Integrated(parameters(0.0, **{"s1.kind": "rate"}))
    found = []
    for k in range(500):
        stamp_ns = SECOND + k * SECOND // 50
        lines.on_s2(Sample(stamp_ns, 0.02 * k))
        if not 100 < k < 300:
            sample = lines.on_s1(Sample(stamp_ns, 1.0))
            assert sample is not None
            found.append(sample.value - 0.02 * k)
    assert found == pytest.approx([0.0] * len(found), abs=1e-9)


HEADING = {
    "s1.kind": "rate",
    "s1.bias_time_constant": 5.0,
    "s1.drift_time_constant": 10.0,
    "s1.drift_prior": 0.01,
    "s2.noise": 0.05,
    "s2.delay": 0.3,
}


def after_a_silence(s2_returns_s: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Time, error and standard deviation while a gyro speaks again, from 63.5 s on.

    It was silent for 3.5 s, in which the heading turned by 2 rad; the course of 1 Hz, 0.3 s old,
    was until some time.
    """

    def heading(time_s: float) -> float:
        return 0.3 * time_s + 1.2 * math.sin(0.4 * time_s)

    fusion, found = Fusion(parameters(**HEADING)), []
    for k in range(7000):
        time_s, stamp_ns = 0.01 * k, SECOND + k * 10_000_000
        if k % 100 == 0 and not 60.0 <= time_s < s2_returns_s:
            fusion.on_s2(Sample(stamp_ns, nearest(heading(time_s - 0.3), 0.0, TURN)))
        if not 60.0 <= time_s < 63.5:
            rate = 0.3 + 0.48 * math.cos(0.4 * time_s) + 0.01
            for fused in fusion.on_s1(Sample(stamp_ns, rate)).estimates:
                error = nearest(fused.estimate.value - heading(time_s), 0.0, TURN)
                found.append((time_s, error, fused.estimate.standard_deviation))
    return np.array([each for each in found if each[0] >= 63.5])


def test_after_a_silence_a_rate_begins_where_s2_leads() -> None:
    """Not where S2 was: that is 0.6 rad behind."""
    time_s, error, sure = after_a_silence(60.0).T
    assert np.abs(error).max() < 0.1
    assert np.abs(error[time_s > 66.0]).max() < 0.05
    assert (np.abs(error) < 3.0 * sure).all()
    assert np.abs(np.diff(error)).max() < 0.1


def test_after_a_silence_of_both_a_rate_knows_little() -> None:
    time_s, error, sure = after_a_silence(64.0).T
    alone = time_s < 63.995
    assert (np.abs(error[alone]) > 1.0).all()
    assert (np.abs(error) < 4.0 * sure).all()  # it also turned faster than before
    assert np.abs(error[~alone]).max() < 0.1


def test_a_rate_without_bounds_stays_finite() -> None:
    fusion = Fusion(parameters(TURN, **{"s1.kind": "rate"}))
    fusion.on_s2(Sample(SECOND, 1.0))
    for k in range(20):
        for fused in fusion.on_s1(Sample(SECOND + k * SECOND // 50, 1.7e308)).estimates:
            assert math.isfinite(fused.estimate.value)


@pytest.mark.parametrize("garbage", [1e3, 1e5, -3.7e6, 1e90])
@pytest.mark.parametrize("samples", [1, 5])
def test_a_heading_recovers_from_garbage_of_a_gyro(garbage: float, samples: int) -> None:
    chosen = parameters(
        **{
            "s1.kind": "rate",
            "s1.bias_time_constant": 5.0,
            "s1.drift_time_constant": 10.0,
            "s1.drift_prior": 0.02,
            "s2.noise": 0.05,
            "s2.delay": 0.3,
        }
    )
    given_rows: list[Row] = []
    for k in range(6000):
        time_s = 0.01 * k
        rate = 0.3 * math.sin(0.2 * time_s) + 0.02
        late = -1.5 * math.cos(0.2 * (time_s - 0.3))
        stamp_ns = SECOND + k * 10_000_000
        if k % 100 == 0:
            given_rows.append((stamp_ns, "s2", nearest(late, 0.0, TURN)))
        given_rows.append((stamp_ns, "s1", garbage if 0 <= k - 2000 < samples else rate))
    said = estimates(given_rows, chosen)
    truth = -1.5 * np.cos(0.2 * 0.01 * np.arange(6000))
    error = arrays.nearest(said - truth[-said.size :], np.zeros(said.size), TURN)
    assert np.abs(error[1500:1990]).max() < 0.05
    assert np.abs(error[-1000:]).max() < 0.1
