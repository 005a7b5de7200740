# SPDX-License-Identifier: Apache-2.0
"""Which of many fields move together."""

from __future__ import annotations

import numpy as np
import pytest

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.relation import Kind
from fuzzy_fusion_ros.checking.report import survey_json, survey_text
from fuzzy_fusion_ros.checking.survey import Field, survey

TIMES: Reals = 0.02 * np.arange(6000)


def walk(seed: int) -> Reals:
    """A motion of its own."""
    generator = np.random.default_rng(seed)
    kernel = np.exp(-np.arange(200) / 40.0)
    return np.convolve(generator.normal(size=6199), kernel, "valid")


def field(topic: str, values: Reals, every: int = 1, path: str = "data") -> Field:
    return Field(topic, path, "", Motion(TIMES[::every], values[::every]))


def later(values: Reals, seconds: float) -> Reals:
    return np.interp(TIMES - seconds, TIMES, values)


OTHERS = [field(f"/other_{k}", walk(100 + k), path=f"position[{k}]") for k in range(12)]


@pytest.mark.parametrize(
    ("scale", "lag", "every"), [(1.0, 0.0, 1), (57.3, 0.3, 10), (-0.01, 0.5, 25), (3.6, 0.1, 5)]
)
def test_two_of_many_that_measure_the_same(scale: float, lag: float, every: int) -> None:
    one = field("/imu", walk(1) + 0.3 * np.random.default_rng(2).normal(size=6000))
    other = field("/gnss", scale * later(walk(1), lag), every)
    (found,) = survey([*OTHERS, other, one])
    assert found.relation.kind is Kind.VALUE
    assert found.relation.correlation > 0.95
    assert found.relation.lag == pytest.approx(lag, abs=0.1)
    assert found.relation.sign * found.relation.middle_scale == pytest.approx(scale, rel=0.1)
    if every > 1:
        assert (found.s1.topic, found.s2.topic) == ("/imu", "/gnss")


def test_a_rate_and_its_value() -> None:
    one = field("/gyro", walk(1))
    other = field("/heading", np.cumsum(walk(1)) * 0.02, 5)
    (found,) = survey([*OTHERS, one, other])
    assert found.relation.kind is Kind.S1_RATE
    assert (found.s1.topic, found.s2.topic) == ("/gyro", "/heading")
    assert "/gyro data, /heading data (s1 is the rate of s2)" in survey_text([found])


def test_fields_of_one_topic_are_no_pair() -> None:
    same = [field("/imu", walk(1), path="a"), field("/imu", walk(1), path="b")]
    assert survey(same) == []


def test_constants_counters_and_short_fields_move_with_nothing() -> None:
    short = Field("/short", "data", "", Motion(TIMES[:5], walk(1)[:5]))
    still = [field("/constant", np.ones(6000)), field("/zero", np.zeros(6000))]
    counters = [field(f"/counter_{k}", k * np.arange(6000.0) + 7.0) for k in (1, 2)]
    assert survey([short, *still, *counters]) == []
    assert survey([]) == []


def test_chance_is_allowed_for() -> None:
    assert survey(OTHERS) == []


def test_what_a_survey_says() -> None:
    found = survey([field("/a", walk(1)), field("/b", -2.0 * later(walk(1), 0.2), 5)])
    head, columns, row = survey_text(found).splitlines()
    assert head == "numbers that move together"
    assert columns.split() == ["correlation", "lag", "scale", "s1,", "s2"]
    assert row.split()[-4:] == ["/a", "data,", "/b", "data"]
    (document,) = survey_json(found)
    assert document["s1"] == {"topic": "/a", "field": "data"}
    assert document["kind"] == "value"
    assert document["sign"] == -1
    assert document["scale"] == pytest.approx(2.0, rel=0.05)
    assert survey_text([]) == "no two numbers of different topics move together"
