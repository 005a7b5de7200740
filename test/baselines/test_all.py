# SPDX-License-Identifier: Apache-2.0
"""What holds for every baseline."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import signals
from searching import examples

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, methods
from fuzzy_fusion_ros.batch.series import Method, Series, run
from fuzzy_fusion_ros.core.estimator import FUSED, WAITING
from fuzzy_fusion_ros.parameters.group import flatten, replace

SECOND = 1_000_000_000
METHODS = methods(BaselineParameters())

anything = st.floats(allow_nan=False, allow_infinity=False)
steps_ns = st.integers(1, 10**13)


def series_of(recording: signals.Recording) -> Series:
    """Return a recording as arrays."""
    return Series(
        s1_ns=np.array([stamp for stamp, _ in recording.s1], np.int64),
        s1=np.array([value for _, value in recording.s1]),
        s2_ns=np.array([stamp for stamp, _ in recording.s2], np.int64),
        s2=np.array([value for _, value in recording.s2]),
        s2_known=np.array(recording.s2_known, np.int64),
    )


def stepped(method: Method, feed: list[tuple[str, int, float]]) -> list[float]:
    """Feed samples one by one; return the estimates, NaN while the method waits."""
    state, found = method.state, []
    for sensor, stamp_ns, value in feed:
        if sensor == "s2":
            state = method.observe_s2(method.parameters, state, stamp_ns, value)
            continue
        estimate, state = method.update(method.parameters, state, stamp_ns, value)
        assert estimate.mode in {WAITING, FUSED}
        found.append(estimate.value if estimate.mode == FUSED else math.nan)
    return found


def feed_of(series: Series) -> list[tuple[str, int, float]]:
    """Return a series sample by sample, in the order in which they came."""
    feed: list[tuple[str, int, float]] = []
    seen = 0
    for k, known in enumerate(series.s2_known.tolist()):
        feed += [("s2", int(series.s2_ns[i]), float(series.s2[i])) for i in range(seen, known)]
        seen = known
        feed.append(("s1", int(series.s1_ns[k]), float(series.s1[k])))
    return feed


def test_their_names_are_those_of_the_scores() -> None:
    assert list(BASELINES) == [
        "s1",
        "s2",
        "average",
        "constant_weight",
        "complementary",
        "complementary_lowpass",
        "kalman",
        "kalman_bias",
        "kalman_lag",
        "kalman_lag_cv",
        "error_state",
    ]


@pytest.mark.parametrize("name", BASELINES)
def test_nothing_comes_out_before_s2_has_spoken(name: str) -> None:
    feed = [("s1", SECOND, 1.0), ("s1", 2 * SECOND, 2.0), ("s2", 2 * SECOND, 3.0)]
    found = stepped(METHODS[name], [*feed, ("s1", 3 * SECOND, 3.0)])
    assert np.isnan(found).tolist() == [True, True, False]


@pytest.mark.parametrize("name", BASELINES)
@given(
    value=st.floats(-1e6, 1e6),
    order=st.lists(st.tuples(st.sampled_from(["s1", "s2"]), steps_ns), max_size=30),
)
def test_two_sensors_that_agree_are_believed(
    name: str, value: float, order: list[tuple[str, int]]
) -> None:
    stamp_ns = SECOND
    feed = [("s2", stamp_ns, value)]
    for sensor, step_ns in order:
        stamp_ns += step_ns
        feed.append((sensor, stamp_ns, value))
    assert stepped(METHODS[name], feed) == pytest.approx(
        [value] * sum(sensor == "s1" for sensor, *_ in feed), rel=1e-9, abs=1e-9
    )


@pytest.mark.parametrize("name", BASELINES)
@examples(200)
@given(
    feed=st.lists(
        st.tuples(st.sampled_from(["s1", "s2"]), st.integers(1, 2**62), anything), max_size=40
    )
)
def test_finite_in_finite_out(name: str, feed: list[tuple[str, int, float]]) -> None:
    feed = [("s2", 1, 0.0), *sorted(feed, key=lambda sample: sample[1])]
    assert np.isfinite(stepped(METHODS[name], feed)).all()


@pytest.mark.parametrize("name", BASELINES)
@examples(50)
@given(data=st.data())
def test_allowed_parameters_keep_it_finite(name: str, data: st.DataObject) -> None:
    own = [each for each in flatten(BaselineParameters()) if each.startswith(f"{name}.")]
    extremes = [1e-12, 1e-6, 0.5, 1.0, 1e3, 1e9]
    changes: dict[str, object] = {}
    for each in own:
        if each.endswith((".biased", ".s2_lags")):
            changes[each] = data.draw(st.booleans())
        else:
            top = 1.0 if each.endswith(".weight") else 1e9
            changes[each] = data.draw(st.sampled_from([x for x in extremes if x <= top]))
    method = BASELINES[name].method(replace(BaselineParameters(), changes))
    series = series_of(signals.irregular(60, seed=data.draw(st.integers(0, 9)), gap_ns=10**12))
    assert np.isfinite(run_values(method, series)).all()


def run_values(method: Method, series: Series) -> list[float]:
    """Return the estimates from the first one on."""
    found = np.array(stepped(method, feed_of(series)))
    first = int(np.argmax(np.isfinite(found)))
    return [float(value) for value in found[first:]]


@pytest.mark.parametrize("name", BASELINES)
def test_stepping_is_the_compiled_run_bit_for_bit(name: str) -> None:
    series = series_of(signals.irregular(500, seed=3, gap_ns=3 * SECOND))
    trace = run(METHODS[name], series)
    found = np.array(stepped(METHODS[name], feed_of(series)))
    assert np.array_equal(np.isnan(found), trace.mode == WAITING)
    assert np.array_equal(np.nan_to_num(found), trace.value)


def test_everything_that_has_parameters_can_be_fitted() -> None:
    moved = {name for each in BASELINES.values() for name in each.moved}
    fixed = {"kalman.process_noise", "kalman.biased", "kalman.bias_noise"}
    fixed |= {"kalman_bias.process_noise", "kalman_bias.biased"}
    fixed |= {"complementary.lowpass_time_constant"}
    fixed |= {"kalman_lag.velocity_deviation", "kalman_lag.velocity_time_constant"}
    fixed |= {"kalman_lag_cv.process_noise"}
    switches = {name for each in BASELINES.values() for name in each.switches}
    assert moved | fixed | switches == set(flatten(BaselineParameters()))
