# SPDX-License-Identifier: Apache-2.0
"""Places along axes, and that no fit can propose what the parameters refuse."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from searching import examples
from tuning.recordings import Sensors, made

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.lag import Lag
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import allowed, descriptors, replace
from fuzzy_fusion_ros.tuning.baselines import attempts
from fuzzy_fusion_ros.tuning.candidates import candidates_for
from fuzzy_fusion_ros.tuning.characterise import Characteristics, characterise
from fuzzy_fusion_ros.tuning.fit import Problem
from fuzzy_fusion_ros.tuning.space import Axis, Space, space_of, usual_bias_time, very_large
from fuzzy_fusion_ros.tuning.tune import rounded

MICROSECOND, HOUR = 1e-6, 3600.0

times = st.floats(np.log(MICROSECOND), np.log(10.0 * HOUR)).map(np.exp).map(float)
sizes = st.floats(np.log(1e-12), np.log(1e15)).map(np.exp).map(float)
shares = st.floats(0.0, 1.0)


@st.composite
def recordings(draw: st.DrawFn) -> Characteristics:
    """Draw the characteristics of a recording, from microseconds to hours, of any unit."""
    return Characteristics(
        span=draw(times) * 1e3,
        s1_interval=draw(times),
        s2_interval=draw(times),
        s2_pause=draw(times),
        s2_gap=draw(times) * 1e3,
        s2_delivery=draw(times),
        s1_noise=draw(sizes),
        s2_noise=draw(sizes),
        spike_share=draw(shares),
        spike_scale=draw(sizes),
        lag=Lag(draw(times), draw(times), draw(shares)),
        chance=draw(shares),
        bias=draw(sizes),
        drift=draw(sizes),
        wander=draw(sizes),
        difference=draw(sizes),
        rate=draw(sizes) / draw(times),
        one_way=draw(shares),
        longest_lag=draw(times),
    )


def points(space: Space, seed: int) -> Iterator[Reals]:
    """Yield two opposite corners of a space, and points at random."""
    n = len(space.axes)
    yield np.zeros(n)
    yield np.ones(n)
    yield from np.random.default_rng(seed).random((5, n))


@examples(200)
@given(sensors=recordings(), seed=st.integers(0, 100))
def test_no_candidate_proposes_what_the_parameters_refuse(
    sensors: Characteristics, seed: int
) -> None:
    nothing = np.zeros(0)
    problem = Problem([], nothing, nothing > 0.0, Parameters())
    for candidate in (*candidates_for(sensors), *candidates_for(sensors, with_truth=False)):
        space = candidate.spec.space
        starts = [space.point(each) for each in candidate.spec.starts]
        for point in [*starts, *points(space, seed)]:
            assert ((point >= 0.0) & (point <= 1.0)).all()
            assert space.away(point) >= 0.0
            found = rounded(problem, replace(Parameters(), space.values(point)))
            assert found.aggregator.weight.order_problem() == ""


@examples(100)
@given(data=st.data(), seed=st.integers(0, 100))
def test_no_baseline_proposes_what_its_parameters_refuse(data: st.DataObject, seed: int) -> None:
    moved = {name for each in BASELINES.values() for name in each.moved}
    drawn = {name: data.draw(sizes) for name in sorted(moved)}
    derived = replace(BaselineParameters(), allowed(BaselineParameters, drawn))
    for attempt in attempts(derived):
        for point in [attempt.space.point({}), *points(attempt.space, seed)]:
            assert ((point >= 0.0) & (point <= 1.0)).all()
            attempt.at(point)


def test_an_axis_ends_where_its_parameter_does() -> None:
    limits = {name: descriptor for name, descriptor, _ in descriptors(Parameters)}
    high = limits["s2.delay"].high
    inside, beyond = (
        space_of(Parameters, [Axis("s2.delay", *ends, 1.0)], {}).axes[0]
        for ends in ((1e-3, 1e9), (1e9, 1e12))
    )
    assert (inside.low, inside.high) == (1e-3, high)
    assert (beyond.low, beyond.high, beyond.place(5.0), beyond.value(0.5)) == (high, high, 0, high)


@pytest.mark.parametrize(
    ("axis", "place", "value"),
    [
        (Axis("a", 0.1, 10.0, 1.0), 0.5, 1.0),
        (Axis("a", 0.1, 10.0, 1.0), 1.0, 10.0),
        (Axis("a", -1.0, 3.0, 0.0, logarithmic=False), 0.25, 0.0),
        (Axis("a", 1.0, 100.0, 0.75, doubt=True), 0.5, 0.9),
    ],
)
def test_axes_go_both_ways(axis: Axis, place: float, value: float) -> None:
    assert axis.value(place) == pytest.approx(value)
    assert axis.place(value) == pytest.approx(place)
    assert axis.place(1e9) == 1.0
    assert axis.place(-1e9) == 0.0


def test_the_point_of_parameters_is_where_they_came_from() -> None:
    for candidate in candidates_for(characterise(made(Sensors(spikes=0.1)).series)):
        space = candidate.spec.space
        point = np.linspace(0.3, 0.7, len(space.axes))
        found = space.point_of(replace(Parameters(), space.values(point)))
        assert found == pytest.approx(point)


def test_a_pull_is_by_the_squared_decade() -> None:
    axes = [
        Axis("s2.delay", 0.01, 100.0, 1.0, pull=0.1),
        Axis("aggregator.weight.small", 0.0, 1.0, 0.5, logarithmic=False, pull=0.2),
    ]
    space = space_of(Parameters, axes, {})
    assert space.away(space.point({})) == 0.0
    assert space.away(space.point({"s2.delay": 10.0})) == pytest.approx(0.1)
    assert space.away(space.point({"s2.delay": 0.01})) == pytest.approx(0.4)
    assert space.away(space.point({"aggregator.weight.small": 1.0})) == pytest.approx(0.05)


def test_what_follows_is_set_too() -> None:
    axis = Axis("aggregator.weight.large", 1.0, 100.0, 0.75, doubt=True)
    space = space_of(Parameters, [axis], {}, very_large)
    values = space.values(space.point({}))
    assert values["aggregator.weight.large"] == pytest.approx(0.75)
    assert values["aggregator.weight.very_large"] == pytest.approx(1.0 - 4.0**-1.5)


def test_a_space_multiplies_shares_out() -> None:
    axes = [
        Axis("aggregator.rate.large", 1.0, 100.0, 10.0),
        Axis(
            "aggregator.rate.small",
            0.0,
            0.5,
            0.1,
            logarithmic=False,
            share_of="aggregator.rate.large",
        ),
    ]
    space = space_of(Parameters, axes, {"s2.timeout": 7.0})
    assert space.values(space.point({"aggregator.rate.small": 0.5})) == pytest.approx(
        {"s2.timeout": 7.0, "aggregator.rate.large": 10.0, "aggregator.rate.small": 5.0}
    )


def test_a_steady_drift_is_no_walk_of_a_bias_with_a_slope() -> None:
    drifting = characterise(made(Sensors(drift=0.5), seed=3).series)
    steady = drifting._replace(drift=0.0)
    assert usual_bias_time(drifting, has_slope=False) < usual_bias_time(steady, has_slope=False)
    assert usual_bias_time(drifting, has_slope=True) == usual_bias_time(steady, has_slope=True)
