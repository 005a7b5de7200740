# SPDX-License-Identifier: Apache-2.0
"""What is wrong between two sensors, and the parameter that fixes it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from checking.made import START_NS, both, only, sensor

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking import pair
from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.finding import Level
from fuzzy_fusion_ros.checking.recent import warnings
from fuzzy_fusion_ros.checking.relation import Kind
from fuzzy_fusion_ros.checking.samples import TwoSensors

T1: Reals = 0.01 * np.arange(6000)
T2: Reals = 0.1 * np.arange(600)
LAG = 0.2
NOISE: Reals = np.random.default_rng(1).normal(size=6000)
NOISE2: Reals = np.random.default_rng(2).normal(size=600)


def motion(time_s: Reals) -> Reals:
    """Three sines that have nothing in common."""
    found: Reals = np.sin(time_s) + np.sin(2.3 * time_s + 1.0) + 0.5 * np.sin(0.37 * time_s)
    return found


def rate(time_s: Reals) -> Reals:
    """The derivative of that."""
    found: Reals = np.cos(time_s) + 2.3 * np.cos(2.3 * time_s + 1.0) + 0.185 * np.cos(0.37 * time_s)
    return found


def checked(s1: Reals, s2: Reals, unit1: str = "", unit2: str = "") -> Check:
    return both(
        sensor("s1", T1, s1 + 0.02 * float(np.std(s1)) * NOISE, unit=unit1),
        sensor("s2", T2, s2 + 0.01 * float(np.std(s2)) * NOISE2, unit=unit2),
    )


def test_nothing_is_wrong() -> None:
    found = checked(0.3 + motion(T1), motion(T2 - LAG))
    assert found.findings == ()
    assert found.is_fine
    assert found.relation is not None
    assert found.relation.lag == pytest.approx(LAG, abs=0.02)
    assert found.relation.middle_scale == pytest.approx(1.0, abs=0.02)


def test_garbage_does_not_keep_sensors_from_being_compared() -> None:
    s1 = motion(T1)
    s1[3000:3005] = 1e3
    found = both(sensor("s1", T1, s1), sensor("s2", T2, motion(T2 - LAG)))
    assert [each.about for each in found.findings] == ["outliers"]
    assert "the first at 30.0 s" in found.findings[0].text
    assert found.relation is not None
    assert found.relation.lag == pytest.approx(LAG, abs=0.02)


@pytest.mark.parametrize(
    ("factor", "about", "text", "remedy"),
    [
        (-1.0, "sign", "s1 has the opposite sign of s2", "s1.scale: -1"),
        (
            180.0 / math.pi,
            "scale",
            "s1 reads 57.3 times what s2 reads: degrees against radians",
            "s1.scale: 0.01745329",
        ),
        (
            math.pi / 180.0,
            "scale",
            "s1 reads 0.0175 times what s2 reads: radians against degrees",
            "s1.scale: 57.29578",
        ),
        (
            1.0 / 9.80665,
            "scale",
            "s1 reads 0.102 times what s2 reads: g against m/s^2",
            "s1.scale: 9.80665",
        ),
        (
            3.6,
            "scale",
            "s1 reads 3.6 times what s2 reads: km/h against m/s",
            "s1.scale: 0.2777778",
        ),
        (
            100.0,
            "scale",
            "s1 reads 100 times what s2 reads: Pa against hPa (or cm, m)",
            "s1.scale: 0.01",
        ),
        (
            1.0 / 0.3048,
            "scale",
            "s1 reads 3.28 times what s2 reads: feet against metres",
            "s1.scale: 0.3048",
        ),
        (
            3.4,  # of the two, km/h is more usual
            "scale",
            "s1 reads 3.6 times what s2 reads: km/h against m/s, "
            "or feet against metres, 3.28 times",
            "s1.scale: 0.2777778",
        ),
        (5.0, "scale", "s1 reads 5 times what s2 reads", "s1.scale: 0.2"),
        (
            -180.0 / math.pi,
            "sign",
            "s1 has the opposite sign of s2, times 57.3: degrees against radians",
            "s1.scale: -0.01745329",
        ),
    ],
)
def test_sign_and_scale(factor: float, about: str, text: str, remedy: str) -> None:
    found = checked(factor * motion(T1), motion(T2 - LAG))
    finding = only(found.findings, about)
    assert finding.level is Level.ERROR
    assert finding.text == text
    assert finding.remedy == remedy
    assert abs(finding.evidence["correlation"]) > 0.98
    assert len(found.findings) == 1


@pytest.mark.parametrize("factor", [0.7, 0.9, 1.2, 1.5])
def test_an_inaccurate_scale_is_no_other_unit(factor: float) -> None:
    assert checked(factor * motion(T1), motion(T2 - LAG)).findings == ()


@pytest.mark.parametrize(
    ("s1", "s2", "text", "remedy"),
    [
        (rate(T1), motion(T2 - LAG), "s1 is the rate of s2", "s1.kind: rate"),
        (
            -rate(T1),
            motion(T2 - LAG),
            "s1 is the negated rate of s2",
            "s1.kind: rate and s1.scale: -1",
        ),
        (
            rate(T1) * 180.0 / math.pi,
            motion(T2 - LAG),
            "s1 is the rate of s2, times 57.3: degrees against radians",
            "s1.kind: rate and s1.scale: 0.01745329",
        ),
        (
            motion(T1),
            rate(T2 - LAG),
            "s2 is the rate of s1",
            "swap --s1 and --s2, and set s1.kind: rate",
        ),
    ],
)
def test_a_rate_for_a_value(s1: Reals, s2: Reals, text: str, remedy: str) -> None:
    found = checked(s1, s2)
    finding = only(found.findings, "rate")
    assert (finding.text, finding.remedy) == (text, remedy)
    assert finding.evidence["as values"] < abs(finding.evidence["correlation"])


def test_what_looks_the_same_either_way_is_no_fault() -> None:
    found = checked(np.sin(2.0 * T1), np.sin(2.0 * (T2 - 0.8)))
    assert found.is_fine
    assert [each.about for each in found.findings] == ["ambiguous"]


@pytest.mark.parametrize(
    ("unit1", "unit2", "about", "text"),
    [
        ("Pa", "m", "units", "s1 is in Pa, s2 in m"),
        ("rad/s", "rad", "rate", "s1 is in rad/s, s2 in rad: one is the rate of the other"),
        ("m", "m/s", "rate", "s1 is in m, s2 in m/s: one is the rate of the other"),
    ],
)
def test_units_that_differ(unit1: str, unit2: str, about: str, text: str) -> None:
    finding = only(checked(0.0 * T1, 0.0 * T2, unit1, unit2).findings, about)
    assert finding.text == text
    assert finding.level is Level.ERROR


@pytest.mark.parametrize("unit2", ["m/s^2", "m"])
def test_a_rate_of_another_quantity_has_no_scale(unit2: str) -> None:
    one = sensor("s1", T1, 9.81 * np.cos(T1), unit="rad/s")
    other = sensor("s2", T2, -np.sin(T2), unit=unit2)
    found = check(TwoSensors(one, other, START_NS, is_rate=True))
    finding = only(found.findings, "units")
    assert (finding.level, finding.text) == (Level.ERROR, f"s1 is in rad/s, s2 in {unit2}")
    assert not {"scale", "sign"} & {each.about for each in found.findings}


def test_units_say_that_a_rate_is_none() -> None:
    one, other = sensor("s1", T1, 0.0 * T1, unit="m/s"), sensor("s2", T2, 0.0 * T2, unit="m/s")
    finding = only(check(TwoSensors(one, other, START_NS, is_rate=True)).findings, "rate")
    assert finding.text == "s1 and s2 are in m/s, but s1.kind is rate"
    assert finding.remedy == "s1.kind: value"


def test_what_is_no_angle_has_no_period() -> None:
    s1, s2 = (15.0 + motion(each) for each in (T1, T2))
    one, other = sensor("s1", T1, s1, unit="m/s"), sensor("s2", T2, s2, unit="m/s")
    found = check(TwoSensors(one, other, START_NS, period=2.0 * np.pi))
    finding = only(found.findings, "period")
    assert finding.text == "signal.period is for angles, but s2 is in m/s"
    assert finding.remedy == "signal.period: 0.0"


def test_units_decide_where_motion_could_be_either() -> None:
    s1, s2 = np.cos(T1), np.sin(T2 - 0.4)
    assert checked(s1, s2, "m", "m").is_fine
    assert only(checked(s1, s2, "m/s", "m").findings, "rate").remedy == "s1.kind: rate"


def test_one_topic_for_both() -> None:
    one = sensor("s1", T1, motion(T1), topic="/imu", field="angular_velocity.x")
    found = both(one, one._replace(name="s2"))
    finding = only(found.findings, "same topic")
    assert finding.text == "s1 and s2 are both /imu angular_velocity.x"
    assert finding.level is Level.ERROR


@pytest.mark.parametrize("every", [1, 10])
def test_a_copy_on_another_topic(every: int) -> None:
    values = motion(T1) + 0.1 * NOISE
    found = both(sensor("s1", T1, values), sensor("s2", T1[::every], values[::every]))
    finding = only(found.findings, "copy")
    assert finding.text == "s2 is a copy of s1: every stamp and value of it is also there"
    assert finding.level is Level.WARNING


def test_sensors_with_each_others_role() -> None:
    found = both(
        sensor("s1", T2, motion(T2 - LAG) + 0.01 * NOISE2),
        sensor("s2", T1, motion(T1) + 0.3 * NOISE),
    )
    finding = only(found.findings, "exchanged")
    assert finding.text == "s1 and s2 look swapped: s2 is faster and noisier and ahead of s1"
    assert finding.remedy == "swap --s1 and --s2"


@pytest.mark.parametrize(("lag", "is_named"), [(0.0, True), (1.0, False)])
def test_a_much_faster_s2_is_enough_to_swap_them_unless_it_lags(lag: float, is_named: bool) -> None:
    found = both(sensor("s1", T2, motion(T2)), sensor("s2", T1, motion(T1 - lag)))
    texts = [each.text for each in found.findings if each.about == "exchanged"]
    assert texts == ["s1 and s2 look swapped: s2 is faster"] * is_named


def test_sensors_that_have_nothing_in_common() -> None:
    other = 2.0 * np.sin(0.83 * T2) + np.sin(1.57 * T2) + np.sin(3.1 * T2 + 1.0)
    finding = only(checked(motion(T1), other).findings, "unrelated")
    assert finding.text == "s1 and s2 are correlated no better than by chance"
    assert finding.level is Level.WARNING


def test_an_angle_that_wraps_is_not_called_unrelated_before_that_is_fixed() -> None:
    other = 4.0 * (np.sin(0.83 * T2) + np.sin(1.57 * T2) + np.sin(3.1 * T2 + 1.0))
    wrapped = np.remainder(other + math.pi, 2.0 * math.pi) - math.pi
    found = both(sensor("s1", T1, motion(T1)), sensor("s2", T2, wrapped))
    assert only(found.findings, "wrap").level is Level.WARNING
    assert "unrelated" not in {each.about for each in found.findings}


def test_sensors_at_rest_are_fine() -> None:
    found = both(sensor("s1", T1, 0.1 * NOISE), sensor("s2", T2, 0.01 * NOISE2))
    assert found.is_fine


def test_sensors_at_rest_whose_noise_is_not_white_are_fine() -> None:
    kernel = np.exp(-np.arange(100) / 10.0)
    s1 = np.convolve(np.random.default_rng(3).normal(size=6099), kernel, "valid")
    s2 = np.convolve(np.random.default_rng(4).normal(size=699), kernel, "valid")
    found = both(sensor("s1", T1, s1), sensor("s2", T2, s2))
    assert found.is_fine


def test_where_units_are_known_only_a_factor_between_units_is_named() -> None:
    odd = checked(5.0 * rate(T1), motion(T2 - LAG), "rad/s", "rad")
    assert only(odd.findings, "rate").remedy == "s1.kind: rate"
    degrees = checked(57.3 * rate(T1), motion(T2 - LAG), "rad/s", "rad")
    assert only(degrees.findings, "rate").remedy == "s1.kind: rate and s1.scale: 0.01745329"
    assert checked(5.0 * motion(T1), motion(T2 - LAG), "m", "m").is_fine


def test_a_rate_by_its_unit_whose_motion_does_not_show_is_not_called_unrelated() -> None:
    other = 2.0 * np.sin(0.83 * T2) + np.sin(1.57 * T2) + np.sin(3.1 * T2 + 1.0)
    found = checked(motion(T1), other, "rad/s", "rad")
    assert {each.about for each in found.findings} == {"rate", "motion"}


def as_rate(s1: Reals, s2: Reals, unit1: str = "", unit2: str = "", period: float = 0.0) -> Check:
    return check(
        TwoSensors(
            sensor("s1", T1, s1 + 0.02 * float(np.std(s1)) * NOISE, unit=unit1),
            sensor("s2", T2, s2 + 0.01 * float(np.std(s2)) * NOISE2, unit=unit2),
            START_NS,
            period,
            is_rate=True,
        )
    )


@pytest.mark.parametrize(("unit1", "unit2"), [("", ""), ("rad/s", "rad"), ("", "m")])
def test_a_rate_that_is_meant_to_be_one_is_fine(unit1: str, unit2: str) -> None:
    found = as_rate(rate(T1), motion(T2 - LAG), unit1, unit2)
    assert found.findings == ()
    assert found.relation is not None
    assert found.relation.kind is Kind.S1_RATE


def test_what_is_wrong_with_a_rate() -> None:
    negated = as_rate(-rate(T1), motion(T2 - LAG))
    assert only(negated.findings, "sign").remedy == "s1.scale: -1"
    degrees = as_rate(57.3 * rate(T1), motion(T2 - LAG))
    assert only(degrees.findings, "scale").remedy == "s1.scale: 0.01745329"
    odd = as_rate(5.0 * rate(T1), motion(T2 - LAG))
    assert only(odd.findings, "scale").remedy == "s1.scale: 0.2"
    assert only(as_rate(-5.0 * rate(T1), motion(T2 - LAG)).findings, "sign").remedy == (
        "s1.scale: -0.2"
    )
    assert as_rate(5.0 * rate(T1), motion(T2 - LAG), period=2.0 * math.pi).findings == ()
    no_rate = as_rate(motion(T1), motion(T2 - LAG))
    assert only(no_rate.findings, "rate").remedy == "s1.kind: value"
    units = as_rate(rate(T1), motion(T2 - LAG), "rad", "rad")
    assert only(units.findings, "rate").remedy == "s1.kind: value"


def test_a_sensor_that_is_stuck() -> None:
    found = checked(np.full(6000, 0.5), motion(T2))
    finding = only(found.findings, "stuck")
    assert finding.text.startswith("s1 is stuck: it reads 0.5 throughout while s2 moves over 3.4")
    assert finding.level is Level.ERROR
    assert len(found.findings) == 1


def test_a_sensor_that_is_stuck_for_a_while() -> None:
    values = motion(T1) + 0.02 * NOISE
    values[3000:4000] = values[3000]
    found = both(sensor("s1", T1, values), sensor("s2", T2, motion(T2 - LAG)))
    finding = only(found.findings, "stuck")
    assert "from 30.0 s to 40.0 s while s2 moves over" in finding.text
    assert finding.level is Level.WARNING


def test_a_coarse_sensor_at_rest_is_not_stuck() -> None:
    moving = T1 < 40.0
    s1 = np.where(moving, np.round(motion(T1), 1), 0.0)
    s2 = np.where(T2 < 40.0, motion(T2 - LAG), 0.0) + 0.05 * NOISE2
    found = both(sensor("s1", T1, s1), sensor("s2", T2, s2))
    assert "stuck" not in {each.about for each in found.findings}


def test_a_silence() -> None:
    there = (T1 < 20.0) | (T1 >= 26.0)
    found = both(
        sensor("s1", T1[there], motion(T1)[there]), sensor("s2", T2, motion(T2 - LAG) + 1e-3)
    )
    finding = only(found.findings, "gap")
    assert finding.text == (
        "s1 is silent once, longest for 6.0 s from 20.0 s on; its usual interval is 0.01 s"
    )
    assert finding.level is Level.WARNING


def test_too_few_samples() -> None:
    found = both(sensor("s1", T1, motion(T1)), sensor("s2", [], []))
    assert only(found.findings, "samples").text == "s2 has no messages"
    found = both(sensor("s1", T1, motion(T1)), sensor("s2", T2[:4], [1.0, 2.0, math.nan, math.inf]))
    text = "2 of 4 samples of s2 can be used, at least 3 are needed"
    assert only(found.findings, "samples").text == text
    assert list(found.characters) == ["s1"]
    assert not found.is_fine


@pytest.mark.parametrize("samples", [1, 2])
def test_messages_without_the_number_explain_too_few_samples(samples: int) -> None:
    s1 = sensor("s1", T1[:samples], motion(T1[:samples]))._replace(unreadable=1798)
    found = both(s1, sensor("s2", T2, motion(T2)))
    assert [each.text for each in found.findings] == [
        f"{samples} of {samples} samples of s1 can be used, at least 3 are needed",
        f"1798 of {1798 + samples} messages of s1 have no readable data",
    ]


def test_messages_without_the_number_are_named_beside_an_overflow() -> None:
    s1 = sensor("s1", T1, 1e101 * motion(T1))._replace(unreadable=7)
    found = both(s1, sensor("s2", T2, motion(T2)))
    assert [each.about for each in found.findings] == ["overflow", "samples"]


def test_a_fault_that_one_half_of_a_recording_contradicts_is_none() -> None:
    late1, late2 = T1 >= 30.0, T2 >= 30.0
    s1 = np.where(late1, rate(T1), 0.2 * motion(T1))
    found = checked(s1, np.where(late2, 1.0, 0.2) * motion(T2))
    assert found.is_fine, found.findings
    (finding,) = found.findings
    assert finding.about == "ambiguous"
    assert finding.text == (
        "the relation between s1 and s2 over the whole recording does not hold in each half"
    )
    weak = np.where(late1, 1.0, 0.2) * motion(T1)
    assert not checked(weak, np.where(late2, -1.0, -0.2) * motion(T2)).is_fine


def test_half_a_recording_at_rest_does_not_hide_a_fault() -> None:
    moving = np.clip((T1 - 25.0) / 5.0, 0.0, 1.0) * motion(T1)
    found = checked(-moving, np.interp(T2 - LAG, T1, moving))
    assert only(found.findings, "sign").remedy == "s1.scale: -1"


def test_a_rate_is_given_no_scale_but_that_between_units() -> None:
    plain, odd, degrees = (
        only(checked(factor * rate(T1), motion(T2 - LAG)).findings, "rate")
        for factor in (1.0, 0.15, 180.0 / math.pi)
    )
    assert plain.remedy == odd.remedy == "s1.kind: rate"
    assert degrees.remedy == "s1.kind: rate and s1.scale: 0.01745329"


def test_constants_are_not_stuck_while_nothing_moves() -> None:
    found = both(sensor("s1", T1, np.ones(6000)), sensor("s2", T2, np.ones(600)))
    assert found.is_fine
    assert [each.about for each in found.findings] == ["motion"]


def test_too_few_samples_are_no_clean_bill() -> None:
    found = both(sensor("s1", T1[:5], motion(T1[:5])), sensor("s2", T2[:5], motion(T2[:5])))
    assert [each.about for each in found.findings] == ["motion"]


def test_values_whose_squares_overflow_are_refused() -> None:
    found = both(sensor("s1", T1, 1e200 * motion(T1)), sensor("s2", T2, motion(T2)))
    (finding,) = found.findings
    assert finding.text.startswith("s1 has values up to ")
    assert finding.text.endswith("e+200, whose squares overflow")
    assert finding.about == "overflow"
    assert finding.evidence == {"samples": np.count_nonzero(np.abs(motion(T1)) > 1e-100)}


def test_a_fix_multiplies_the_scale_that_is_set() -> None:
    s1 = sensor("s1", T1, -motion(T1) + 0.02 * NOISE)._replace(scale=-2.0)
    found = both(s1, sensor("s2", T2, motion(T2 - LAG) + 0.01 * NOISE2))
    assert only(found.findings, "sign").remedy == "s1.scale: 2"
    degrees = sensor("s1", T1, 57.29578 * motion(T1) + NOISE)._replace(scale=-1.0)
    found = both(degrees, sensor("s2", T2, motion(T2 - LAG) + 0.01 * NOISE2))
    assert only(found.findings, "scale").remedy == "s1.scale: -0.01745329"


@pytest.mark.parametrize(
    ("period", "unit1", "unit2", "given", "text"),
    [
        (360.0, "rad/s", "rad", "", "s2 is in rad, where a turn is 6.283185307179586"),
        (360.0, "rad/s", "", "", "s1 is in rad/s, where a turn is 6.283185307179586"),
        (360.0, "", "", "rad", "the signal is in rad, where a turn is 6.283185307179586"),
        (2.0 * math.pi, "deg", "deg", "", "s2 is in deg, where a turn is 360"),
        (2.0 * math.pi, "rad/s", "rad", "", ""),
        (math.pi, "rad/s", "rad", "", ""),  # an axis without direction
        (3.14, "rad/s", "rad", "", ""),
        (360.0, "deg", "deg", "", ""),
        (360.0, "", "", "", ""),
        (0.0, "rad/s", "rad", "", ""),
    ],
)
def test_a_period_in_another_unit_is_named(
    period: float, unit1: str, unit2: str, given: str, text: str
) -> None:
    s1, s2 = sensor("s1", T1, rate(T1), unit=unit1), sensor("s2", T2, motion(T2), unit=unit2)
    found = check(TwoSensors(s1, s2, START_NS, period, is_rate=True, unit=given)).findings
    if not text:
        assert "period" not in {each.about for each in found}
        return
    finding = only(found, "period")
    assert finding.text == f"signal.period is {period:.10g}, but {text}"
    assert finding.level is Level.WARNING
    assert finding.remedy == f"signal.period: {text.split()[-1]}"


@pytest.mark.parametrize(("unit", "turn"), [("rad", 2.0 * math.pi), ("deg", 360.0)])
@pytest.mark.parametrize("wrong", [1.0, 7.0, 360.0, 6.0])
@pytest.mark.parametrize("named", [False, True])
def test_a_wrong_period_is_all_that_is_named(
    unit: str, turn: float, wrong: float, named: bool
) -> None:
    def angle(values: Reals) -> Reals:
        share = values - np.round(values)
        found: Reals = turn * share
        return found

    period = wrong if unit == "rad" else math.pi * wrong
    of_types, given = ("", unit) if named else (unit, "")
    s1 = sensor("s1", T1, angle(0.4 * motion(T1) + 0.01 * NOISE), unit=of_types)
    s2 = sensor("s2", T2, angle(0.4 * motion(T2 - LAG) + 0.002 * NOISE2), unit=of_types)
    found = check(TwoSensors(s1, s2, START_NS, period, unit=given))
    assert [each.about for each in found.findings] == ["period"]
    assert found.relation is not None
    assert found.relation.correlation > 0.9


@pytest.mark.parametrize("kind", ["value", "rate"])
@pytest.mark.parametrize(
    ("at_rest", "named"),
    [
        (0.8 * NOISE2, True),
        (0.02 * NOISE2, False),  # as noisy as in motion
        (0.3 * (T2 - 20.0), False),  # S1 does not see a motion one way
        (np.where(T2 > 22.0, 1.0, 0.0), False),  # one step
    ],
)
def test_an_s2_that_means_nothing_at_rest_is_named(kind: str, at_rest: Reals, named: bool) -> None:
    def course(time_s: Reals) -> Reals:
        moving = np.minimum(time_s, 20.0) + np.maximum(time_s - 24.0, 0.0)
        found: Reals = motion(moving)
        return found

    values = course(T1) if kind == "value" else np.gradient(course(T1), T1)
    s2 = course(T2 - 0.1) + 0.02 * NOISE2 + np.where((T2 > 20.2) & (T2 < 24.0), at_rest, 0.0)
    sensors = TwoSensors(
        sensor("s1", T1, values + 0.002 * NOISE),
        sensor("s2", T2, turned(s2)),
        START_NS,
        2.0 * math.pi,
        is_rate=kind == "rate",
    )
    found = check(sensors)
    assert ("restless" in {each.about for each in found.findings}) is named
    if named:
        finding = only(found.findings, "restless")
        assert finding.level is Level.INFO
        assert finding.remedy.startswith("let its driver withhold it at rest")
        assert "s2.outlier_threshold: 4" in finding.remedy
        assert found.is_fine


def turned(angle: Reals) -> Reals:
    """Return an angle in rad from -pi to pi."""
    found: Reals = angle - 2.0 * math.pi * np.round(angle / (2.0 * math.pi))
    return found


def test_values_at_the_limit_of_numbers_are_refused_too() -> None:
    huge = 1.7e308 * np.where(np.arange(T1.size) % 2, 1.0, -1.0)
    found = both(sensor("s1", T1, huge), sensor("s2", T2, motion(T2)))
    assert [each.about for each in found.findings] == ["overflow"]
    few = np.where(np.arange(T2.size) < 2, 1.7e308 * (-1.0) ** np.arange(T2.size), motion(T2))
    with np.errstate(over="raise"):
        found = both(sensor("s1", T1, huge), sensor("s2", T2, few))
    assert {each.about for each in found.findings} == {"overflow"}


@pytest.mark.parametrize(
    ("period", "named"),
    [
        (360.0, False),
        (180.0, False),
        (90.0, False),
        (6.0, True),
        (3.0, True),
        (1.0, True),
        (1e-9, True),
    ],
)
def test_a_turn_has_few_periods(period: float, named: bool) -> None:
    angle = 100.0 * motion(T1)
    s1, s2 = (sensor(name, T1, angle, unit="deg") for name in ("s1", "s2"))
    sensors = TwoSensors(s1, s2, START_NS, period)
    assert (pair.period_of(sensors) == 360.0) == (named or period == 360.0)
    assert bool(pair.wrong_period(sensors)) is named


def flipped(at_s: float, before: float, after: float) -> Reals:
    """The motion times one factor until a time, and times another from then on."""
    found: Reals = motion(T1) * np.where(at_s > T1, before, after)
    return found


@pytest.mark.parametrize(
    ("s1", "text"),
    [
        (flipped(30.0, 1.0, -1.0), "s1 has the sign of s2 until 29.9 s and the opposite from "),
        (flipped(37.0, 1.0, -1.0), "s1 has the sign of s2 until 29.9 s and the opposite from "),
        (flipped(50.0, 1.0, -1.0), "s1 has the sign of s2 until 44.9 s and the opposite from 52.5"),
        (flipped(20.0, -1.0, 1.0), "s1 has the opposite of s2 until 14.9 s and the sign from "),
        (flipped(30.0, 1.0, 3.0), "s1 reads 1 times what s2 reads until 29.9 s and 3 times from "),
        (
            flipped(44.0, 57.3, 1.0),
            "s1 reads 57 times what s2 reads until 44.9 s and 1 times from ",
        ),
    ],
)
def test_a_sign_or_scale_that_changes(s1: Reals, text: str) -> None:
    found = both(
        sensor("s1", T1, s1 + 0.1 * NOISE), sensor("s2", T2, motion(T2 - LAG) + 0.01 * NOISE2)
    )
    (finding,) = found.findings
    assert (finding.about, finding.level) == ("changed", Level.WARNING)
    assert finding.text.startswith(text)
    assert "--start" in finding.remedy
    assert warnings(found) == [finding]
    assert found.relation is None


def test_a_change_has_the_correlation_on_either_side() -> None:
    s1 = flipped(30.0, 1.0, -1.0) + 0.01 * NOISE
    finding = only(checked(s1, motion(T2 - LAG)).findings, "changed")
    before, after = finding.evidence.values()
    assert before > 0.99
    assert after < -0.99
    assert f" (correlation before {before:.3g}, correlation after {after:.3g}); " in str(finding)


@pytest.mark.parametrize(
    "bent",
    [lambda x: x * np.abs(x), lambda x: np.sign(x) * np.sqrt(np.abs(x)), lambda x: x + 2.0 * x**3],
    ids=["square", "root", "cubic"],
)
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_an_s1_that_bends_has_not_changed(bent: Callable[[Reals], Reals], noise: float) -> None:
    """The motion becomes five times as large: one that is not linear then has another slope."""

    def grown(time_s: Reals) -> Reals:
        found: Reals = motion(time_s) * np.where(time_s < 45.0, 0.2, 1.0)
        return found

    s1 = bent(grown(T1))
    found = both(
        sensor("s1", T1, s1 + noise * float(np.std(s1)) * NOISE),
        sensor("s2", T2, grown(T2 - LAG) + 0.001 * NOISE2),
    )
    assert found.is_fine, found.findings
    s1 = grown(T1) * np.where(T1 < 45.0, 1.0, 4.0)
    found = both(sensor("s1", T1, s1 + 0.01 * NOISE), sensor("s2", T2, grown(T2 - LAG)))
    assert [each.about for each in found.findings] == ["changed"]


def test_two_sines_that_drift_apart_have_not_changed() -> None:
    found = checked(np.sin(2.0 * T1), np.sin(2.05 * T2))
    assert "changed" not in {each.about for each in found.findings}


def test_what_is_called_unrelated_is_within_chance() -> None:
    other = 2.0 * np.sin(0.83 * T2) + np.sin(1.57 * T2) + np.sin(3.1 * T2 + 1.0)
    evidence = only(checked(motion(T1), other).findings, "unrelated").evidence
    found, by_chance = evidence["correlation"], evidence["up to by chance"]
    assert found <= by_chance <= 1.0
