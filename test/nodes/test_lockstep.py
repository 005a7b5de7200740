# SPDX-License-Identifier: Apache-2.0
"""The main invariant: live, in lockstep over DDS, is the simulation, bit for bit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from bag.making import decoded

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.batch.series import fusion
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import Run, simulate
from fuzzy_fusion_ros.simulation.scenario import Scenario
from fuzzy_fusion_ros.testing import Harness

SEED = 7
SCENARIO = {"duration": 4.0, "disturbance.start": 2.0, "disturbance.end": 2.1}
PREDICTOR = pytest.mark.parametrize("predictor", [False, True], ids=["FA alone", "FA and FP"])
TOPICS = ("/truth", "/s1", "/s2", "/estimate", "/control")


def simulated(predictor: bool) -> Run:
    """The same run in this process, no message in sight."""
    parameters = replace(Parameters(), {"predictor.enabled": predictor})
    scenario = replace(Scenario(), SCENARIO)
    return simulate(fusion(parameters), scenario, np.random.default_rng(SEED))


def recorded(bag: Path) -> dict[str, np.ndarray]:
    """What a bag holds: stamps and numbers of each topic, as they are."""
    with open_bag(bag) as reader:
        rows: dict[str, list[tuple[int, float]]] = {topic: [] for topic in TOPICS}
        for message in reader.messages(TOPICS):
            point = decoded(message)
            stamp = point.header.stamp
            rows[message.topic].append((stamp.sec * 10**9 + stamp.nanosec, point.point.x))
    return {topic: np.array(values, dtype=object) for topic, values in rows.items()}


def assert_same(bag: Path, run: Run) -> None:
    """Every number in a bag equals the run's, to the last bit."""
    wanted = (run.truth, run.s1, run.s2, run.trace.value, run.control)
    for topic, values in zip(TOPICS, wanted, strict=True):
        rows = recorded(bag)[topic]
        assert rows[:, 0].tolist() == run.stamps_ns.tolist(), topic
        assert rows[:, 1].tolist() == values.tolist(), topic


def run_here(harness: Harness, bag: Path, predictor: bool) -> None:
    """Run both nodes in this process."""
    harness.fusion_node({"predictor.enabled": predictor})
    pendulum = harness.add(PendulumNode, {**SCENARIO, "seed": SEED, "record": str(bag)})
    harness.spin_until(lambda: pendulum.finished, "the end of the run")
    harness.remove(pendulum)


@PREDICTOR
def test_both_nodes_in_one_process_give_the_simulation(
    harness: Harness, tmp_path: Path, predictor: bool
) -> None:
    run_here(harness, tmp_path / "bag", predictor)
    assert_same(tmp_path / "bag", simulated(predictor))


@pytest.mark.parametrize(
    "predictor",
    [
        True,
        pytest.param(False, marks=pytest.mark.slow("as with the predictor")),
    ],
    ids=["FA and FP", "FA alone"],
)
def test_two_processes_give_the_simulation(
    harness: Harness, tmp_path: Path, predictor: bool
) -> None:
    enabled = f"predictor.enabled:={str(predictor).lower()}"
    scenario = [word for name, value in SCENARIO.items() for word in ("-p", f"{name}:={value}")]
    record = f"record:={tmp_path / 'bag'}"
    fusion_node = harness.start("fusion_node", "--ros-args", "-p", "qos:=reliable", "-p", enabled)
    pendulum = harness.start(
        "pendulum_node", "--ros-args", *scenario, "-p", f"seed:={SEED}", "-p", record
    )
    assert pendulum.wait() == 0, pendulum.stderr
    assert fusion_node.status is None, fusion_node.stderr
    assert_same(tmp_path / "bag", simulated(predictor))


def test_two_runs_with_one_seed_write_the_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "other"):
        with Harness() as harness:
            run_here(harness, tmp_path / name / "bag", predictor=True)
    one, other = (tmp_path / name / "bag" / "bag_0.mcap" for name in ("one", "other"))
    assert one.read_bytes() == other.read_bytes()


def test_a_nodes_own_recording_holds_what_went_through_it(harness: Harness, tmp_path: Path) -> None:
    fused = harness.fusion_node({"record": str(tmp_path / "fusion")})
    run = {**SCENARIO, "duration": 0.5, "record": str(tmp_path / "pendulum")}
    pendulum = harness.add(PendulumNode, run)
    harness.spin_until(lambda: pendulum.finished, "the end of the run")
    harness.remove(pendulum)
    harness.remove(fused)
    with open_bag(tmp_path / "fusion") as mine, open_bag(tmp_path / "pendulum") as theirs:
        for topic in ("/s1", "/s2", "/estimate"):
            ours = [message.data for message in mine.messages([topic])]
            assert ours == [message.data for message in theirs.messages([topic])]
            assert len(ours) == 50
        counts = {name: topic.message_count for name, topic in mine.topics.items()}
    assert counts["/fusion_node/weight"] == 50
    assert counts["/fusion_node/firing_strengths"] == 50
    assert counts["/fusion_node/prediction"] == 0
