# SPDX-License-Identifier: Apache-2.0
"""What always holds: live, replayed and simulated runs are one, and finite."""

from __future__ import annotations

import math
import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag.making import decoded
from bag.recorded import messages, read, swing, write_scalars
from hypothesis import given
from hypothesis import strategies as st
from searching import examples

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.batch.series import fusion, run
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.offline.replay import differences, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.fusion import Fused, Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario
from fuzzy_fusion_ros.testing import Harness

SECONDS = 3.0
EXPLAINED = [f"/fusion_node/{name}" for name in EXPLANATION]
RECORDED = ["/truth", "/s1", "/s2", "/estimate", "/control"]

VARIANTS: dict[str, dict[str, Any]] = {
    "plain": {},
    "predictor": {"predictor.enabled": True},
    "paired": {"trigger": "pair", "predictor.enabled": True},
    "self-tuning": {"self_tuning": True},
}


AS_IN_ONE = pytest.mark.slow("as in one process; the predictor's run shows that two change nothing")


def run_in_one_process(folder: Path, changes: dict[str, Any], seed: int) -> None:
    """Close the loop over DDS between two nodes of this process; both record."""
    with Harness() as harness:
        harness.fusion_node({**changes, "record": str(folder / "fusion")})
        pendulum = harness.add(
            PendulumNode,
            {"duration": SECONDS, "seed": seed, "record": str(folder / "pendulum")},
        )
        harness.spin_until(lambda: pendulum.finished, "the end of the run")


def run_in_two_processes(folder: Path, changes: dict[str, Any], seed: int) -> None:
    """Close the loop over DDS between two processes; both record."""
    with Harness() as harness:
        settings = {**changes, "qos": "reliable", "record": str(folder / "fusion")}
        node = harness.start("fusion_node", *ros_arguments(settings))
        settings = {"duration": SECONDS, "seed": seed, "record": str(folder / "pendulum")}
        pendulum = harness.start("pendulum_node", *ros_arguments(settings))
        assert pendulum.wait() == 0, pendulum.stderr + node.stderr
        node.send(signal.SIGINT)
        assert node.wait() == 0, node.stderr


def ros_arguments(settings: dict[str, Any]) -> list[str]:
    """Return parameters as a command line gives them."""
    given = [
        f"{name}:={str(value).lower() if value is True else value}"
        for name, value in settings.items()
    ]
    return ["--ros-args", *(word for each in given for word in ("-p", each))]


def values(path: Path, topic: str) -> list[float]:
    """Return the numbers on a topic."""
    with open_bag(path) as bag:
        return [decoded(each).point.x for each in bag.messages([topic])]


def replayed(source: Path, output: Path, changes: dict[str, Any]) -> Path:
    """Replay a bag offline."""
    with open_bag(source) as bag:
        replay(bag, output, Topics(), replace(Parameters(), changes))
    return output


@pytest.mark.parametrize(
    ("live", "name"),
    [
        (run_in_one_process, "plain"),
        (run_in_one_process, "predictor"),
        (run_in_one_process, "self-tuning"),
        (run_in_two_processes, "predictor"),
        pytest.param(run_in_two_processes, "plain", marks=AS_IN_ONE),
        pytest.param(run_in_two_processes, "self-tuning", marks=AS_IN_ONE),
    ],
)
def test_live_replayed_and_simulated_runs_are_one(tmp_path: Path, live: Any, name: str) -> None:
    # Two topics can overtake one another, so what is to repeat takes its samples in pairs.
    changes = {**VARIANTS[name], "trigger": "pair"}
    live(tmp_path, changes, 5)
    simulated = simulate(
        fusion(replace(Parameters(), changes)),
        replace(Scenario(), {"duration": SECONDS}),
        np.random.default_rng(5),
    )
    recorded = tmp_path / "pendulum"
    assert values(recorded, "/truth") == simulated.truth.tolist()
    assert values(recorded, "/s1") == simulated.s1.tolist()
    assert values(recorded, "/s2") == simulated.s2.tolist()
    assert values(recorded, "/estimate") == simulated.trace.value.tolist()
    assert values(recorded, "/control") == simulated.control.tolist()

    again = replayed(recorded, tmp_path / "replayed", changes)
    assert differences(recorded, again, RECORDED) == []
    again = replayed(tmp_path / "fusion", tmp_path / "explained", changes)
    assert differences(tmp_path / "fusion", again, ["/s1", "/s2", "/estimate", *EXPLAINED]) == []
    assert len(messages(again, EXPLAINED[:1])) == 300


def test_two_runs_with_one_seed_write_the_same_messages(tmp_path: Path) -> None:
    for name in ("one", "two", "other"):
        run_in_one_process(tmp_path / name, VARIANTS["paired"], 7 + (name == "other"))
    one, two, other = (messages(tmp_path / name / "pendulum") for name in ("one", "two", "other"))
    assert one == two
    assert one != other
    assert (
        differences(
            tmp_path / "one" / "fusion", tmp_path / "two" / "fusion", ["/estimate", *EXPLAINED]
        )
        == []
    )


@pytest.mark.parametrize("name", VARIANTS)
def test_a_looped_bag_gives_the_same_estimates_each_time(tmp_path: Path, name: str) -> None:
    loops = [
        each._replace(log_s=each.time_s + 10.0 * loop) for loop in range(3) for each in swing()
    ]
    again = replayed(write_scalars(tmp_path / "bag", loops), tmp_path / "out", VARIANTS[name])
    found = [each.data for each in messages(again, ["/estimate"])]
    assert len(found) in {1500, 150}
    assert found == found[: len(found) // 3] * 3


@pytest.mark.parametrize("name", VARIANTS)
def test_stepping_is_the_run_over_the_whole_series(tmp_path: Path, name: str) -> None:
    parameters = replace(Parameters(), VARIANTS[name])
    path = write_scalars(tmp_path / "bag", swing())
    trace = run(fusion(parameters), read(path, parameters=parameters).series)
    stepped = values(replayed(path, tmp_path / "out", VARIANTS[name]), "/estimate")
    assert stepped == trace.value[trace.mode > 0].tolist()


any_number = st.one_of(
    st.floats(), st.sampled_from([0.0, 1e308, -1e308, 5e-324, math.nan, math.inf, -math.inf])
)
feeds = st.lists(
    st.tuples(
        st.sampled_from(["s1", "s2", "tick"]),
        st.one_of(st.integers(-(10**9), 10**9), st.integers(-(2**40), 2**62)),
        any_number,
    ),
    max_size=60,
)


def fed(parameters: Parameters, feed: list[tuple[str, int, float]]) -> list[Fused]:
    """Feed anything at all; steps of time may be backwards."""
    node, now_ns = Fusion(parameters), 10**18
    found: list[Fused] = []
    for what, step_ns, value in feed:
        now_ns = min(max(now_ns + step_ns, 0), 2**62)
        if what == "tick":
            found += node.on_tick().estimates
        else:
            receive = node.on_s1 if what == "s1" else node.on_s2
            found += receive(Sample(now_ns, value)).estimates
    return found


CONDITIONED: Mapping[str, object] = {
    "s1.lowpass_time_constant": 0.1,
    "s1.bias_time_constant": 1.0,
    "s1.drift_time_constant": 1.0,
    "s2.lag_time_constant": 0.1,
    "s2.delay": 0.1,
}
EXTENSIONS: tuple[Mapping[str, object], ...] = (
    {},
    CONDITIONED,
    {**CONDITIONED, "adapt.lag_time_constant": 5.0, "adapt.scale_time_constant": 5.0},
    {**CONDITIONED, "s1.kind": "rate", "signal.period": 6.28, "s2.outlier_threshold": 4.0},
    {"self_tuning": True},
)


@pytest.mark.parametrize("trigger", ["s1", "pair", "timer"])
@examples(150)
@given(feed=feeds, extension=st.sampled_from(EXTENSIONS))
def test_whatever_comes_in_what_comes_out_is_finite(
    trigger: str, feed: list[tuple[str, int, float]], extension: Mapping[str, object]
) -> None:
    changes = {
        "trigger": trigger,
        "predictor.enabled": True,
        "predictor.samples": 3,
        "predictor.rules": 2,
        **extension,
    }
    for fused in fed(replace(Parameters(), changes), feed):
        assert_finite(fused)


def assert_finite(fused: Fused) -> None:
    estimate = fused.estimate
    numbers = (estimate.value, *estimate.aggregate[:3], *estimate.aggregate.strengths)
    assert np.isfinite(numbers).all()
    assert np.isfinite(estimate.prediction.value)
    assert 0.0 <= estimate.aggregate.weight <= 1.0
    assert 0.0 <= estimate.standard_deviation < np.inf


@pytest.mark.parametrize(
    ("extension", "feed"),
    [
        (  # ten days without S1: a variance that loses all its digits at the next sample of S2
            CONDITIONED,
            [
                ("s1", 0, 1.0),
                ("s2", 917_838_721_125_431, 0.0),
                ("s2", 908_155_618_193, 1.0),
                ("s1", -334_122_871, 0.0),
                ("s2", 651_081_001, 0.0),
                ("s1", 1, -0.34),
            ],
        ),
        (  # one number of garbage: S1's scale by which it would explain S2
            {**CONDITIONED, "adapt.scale_time_constant": 5.0},
            [
                ("s1", 0, -1356.9),
                ("s2", 1, 0.0),
                ("s1", 2_264_316_446_652_451_194, 1e300),
                ("s1", 1_000_000_000_000_000_000, 954.8),
                ("s2", 560_905, -1.05),
            ],
        ),
    ],
)
def test_what_has_not_come_out_finite(
    extension: Mapping[str, object], feed: list[tuple[str, int, float]]
) -> None:
    found = fed(replace(Parameters(), extension), feed)
    assert found
    for fused in found:
        assert_finite(fused)


@examples(200)
@given(
    s1=st.floats(-1e9, 1e9),
    s2=st.lists(st.floats(-1e9, 1e9), min_size=1, max_size=5),
    weights=st.lists(st.floats(0.0, 1.0), min_size=4, max_size=4),
    drift=st.floats(0.0, 1e3),
)
def test_fa_stays_between_the_sensors_but_for_the_drift(
    s1: float, s2: list[float], weights: list[float], drift: float
) -> None:
    names = ("very_small", "small", "large", "very_large")
    levels = dict(zip((f"aggregator.weight.{name}" for name in names), weights, strict=True))
    node = Fusion(replace(Parameters(), {**levels, "aggregator.drift.large": drift}))
    for k, value in enumerate(s2):
        stamp_ns = 10**18 + k * 10**7
        node.on_s2(Sample(stamp_ns, value))
        (fused,) = node.on_s1(Sample(stamp_ns, s1)).estimates
        fa = fused.estimate.aggregate
        assert min(s1, value) - fa.drift <= fa.value <= max(s1, value) + fa.drift
        assert fa.drift <= drift * (1.0 + 1e-12)
