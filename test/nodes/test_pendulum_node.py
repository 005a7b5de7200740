# SPDX-License-Identifier: Apache-2.0
"""pendulum_node: every feedback, paced or in lockstep, and what it says when alone."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag.making import decoded
from builtin_interfaces.msg import Time
from nodes.watching import Log
from rclpy.qos import QoSProfile

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.baselines.parameters import BaselineParameters
from fuzzy_fusion_ros.baselines.registry import methods
from fuzzy_fusion_ros.nodes.pendulum_node import PeerError, PendulumNode
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.simulation.closed_loop import simulate
from fuzzy_fusion_ros.simulation.scenario import START_NS, Scenario
from fuzzy_fusion_ros.testing import Harness

SECONDS, SEED = 1.0, 3
SHORT = {"duration": SECONDS, "seed": SEED}
FEEDBACKS = ("s1", "s2", "average", "truth")


def points(bag: Path, topic: str) -> list[float]:
    with open_bag(bag) as reader:
        return [decoded(message).point.x for message in reader.messages([topic])]


def run(harness: Harness, parameters: dict[str, Any]) -> PendulumNode:
    """Run a pendulum to its end."""
    pendulum = harness.add(PendulumNode, parameters)
    harness.spin_until(lambda: pendulum.finished, "the end of the run")
    harness.remove(pendulum)
    return pendulum


@pytest.mark.parametrize("feedback", FEEDBACKS)
def test_every_feedback_is_the_simulation_bit_for_bit(
    harness: Harness, tmp_path: Path, feedback: str
) -> None:
    bag = tmp_path / "bag"
    run(harness, {**SHORT, "feedback": feedback, "record": str(bag)})
    exact = {"s1_sensor.bias": 0.0, "s1_sensor.noise": 0.0} if feedback == "truth" else {}
    method = methods(BaselineParameters())["s1" if feedback == "truth" else feedback]
    scenario = replace(Scenario(), {"duration": SECONDS, **exact})
    wanted = simulate(method, scenario, np.random.default_rng(SEED))
    assert points(bag, "/truth") == wanted.truth.tolist()
    assert points(bag, "/control") == wanted.control.tolist()
    assert points(bag, "/s2") == wanted.s2.tolist()


def test_a_fall_ends_the_run_and_is_said(harness: Harness, log: Log, tmp_path: Path) -> None:
    unstable = {"controller.proportional": 0.0, "controller.derivative": 0.0, "duration": 50.0}
    bag = tmp_path / "bag"
    pendulum = run(harness, {**unstable, "feedback": "truth", "record": str(bag)})
    assert pendulum.failure is None
    log.wait_for("the pendulum fell after")
    truth = points(bag, "/truth")
    assert 10 < len(truth) < 5000
    assert abs(truth[-1]) < np.pi / 2


def test_the_joint_is_the_truth(harness: Harness) -> None:
    truth = harness.record("/truth")
    joints = harness.record("/joint_states", "sensor_msgs/msg/JointState")
    run(harness, {**SHORT, "feedback": "truth", "duration": 0.2})
    harness.spin_until(lambda: len(truth) == len(joints) == 20)
    assert [list(joint.name) for joint in joints] == [["pole"]] * 20
    assert [joint.position[0] for joint in joints] == [each.point.x for each in truth]
    assert [joint.header.stamp for joint in joints] == [each.header.stamp for each in truth]


def test_alone_it_ends_with_one_clear_error(harness: Harness) -> None:
    harness.add(PendulumNode, {"timeout": 0.3})
    with pytest.raises(PeerError) as refusal:
        harness.spin_until(lambda: False)
    assert str(refusal.value) == (
        "nobody subscribes to /s1, nobody subscribes to /s2, nobody publishes /estimate within "
        "0.3 s: start fusion_node so that it subscribes to /s1 and /s2 and publishes /estimate"
    )


def test_a_silent_estimator_ends_it_with_one_clear_error(harness: Harness) -> None:
    harness.fusion_node({"s1.field": "point.y", "trigger": "timer", "rate": 0.001})
    harness.add(PendulumNode, {"timeout": 0.3})
    with pytest.raises(PeerError, match=r"no estimate for the sample stamped 1000000000 ns within"):
        harness.spin_until(lambda: False)


def test_it_waits_for_peers_that_come_later(harness: Harness, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    pendulum = harness.add(PendulumNode, {**SHORT, "record": str(bag)})
    assert not pendulum.finished
    harness.fusion_node()
    harness.spin_until(lambda: pendulum.finished)
    harness.remove(pendulum)
    assert len(points(bag, "/truth")) == len(points(bag, "/estimate")) == 100


def test_another_estimator_will_do(harness: Harness) -> None:
    """One that keeps nothing for late joiners, and takes S1 as it is, best effort."""
    publisher = harness.publisher("/estimate", qos=QoSProfile(depth=10))
    node = harness.node
    kind = publisher.msg_type
    node.create_subscription(kind, "/s1", publisher.publish, QoSProfile(depth=10))
    harness.record("/s2")
    run(harness, {**SHORT, "duration": 0.5})


@pytest.mark.parametrize("clock", [False, True], ids=["of the wall", "published"])
def test_paced_runs_follow_a_clock(harness: Harness, clock: bool) -> None:
    node = harness.fusion_node()
    s1 = harness.record("/s1")
    clocks = harness.record("/clock", "rosgraph_msgs/msg/Clock")
    before_ns = node.get_clock().now().nanoseconds
    parameters = {"duration": 0.3, "real_time_factor": 20.0, "publish_clock": clock}
    run(harness, parameters)
    after_ns = node.get_clock().now().nanoseconds
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in s1]
    assert {b - a for a, b in pairwise(stamps)} == {10_000_000}
    assert len(stamps) == 30
    if clock:
        assert stamps[0] == START_NS
        assert [m.clock for m in clocks] == [m.header.stamp for m in s1]
    else:
        assert before_ns <= stamps[0] <= after_ns
        assert clocks == []


def test_stamps_of_a_paced_run_do_not_fall_behind_the_clock(harness: Harness) -> None:
    """A stalled machine misses ticks of the timer; the stamps must not age by them for ever."""
    clock = harness.publisher("/clock", "rosgraph_msgs/msg/Clock")
    s1 = harness.record("/s1")
    parameters = {"duration": 1e3, "real_time_factor": 1.0, "feedback": "truth"}
    pendulum = harness.add(PendulumNode, {**parameters, "use_sim_time": True})

    def show(seconds: int) -> None:
        clock.publish(clock.msg_type(clock=Time(sec=seconds)))
        now = pendulum.get_clock().now
        harness.spin_until(lambda: now().nanoseconds == seconds * 10**9, "the clock")
        seen = len(s1)
        harness.spin_until(lambda: len(s1) > seen + 2, "S1")

    show(100)
    show(105)
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in s1]
    assert stamps[-1] >= 105 * 10**9
    assert {b - a for a, b in pairwise(stamps) if b - a < 10**9} == {10_000_000}
    assert sum(b - a > 10**9 for a, b in pairwise(stamps)) <= 2  # from 0 to 100, to 105


def test_a_paced_run_balances_on_the_newest_estimate(harness: Harness, log: Log) -> None:
    harness.fusion_node()
    run(harness, {"duration": 2.0, "real_time_factor": 4.0})
    log.wait_for("the pendulum was balanced for 2 s")


def test_what_a_run_is_cannot_be_changed_while_it_runs(harness: Harness) -> None:
    pendulum = harness.add(PendulumNode)
    parameter = pendulum.get_parameter("plant.gravity")
    (result,) = pendulum.set_parameters([parameter])
    assert not result.successful
    assert result.reason == (
        f"parameter plant.gravity: got {parameter.value}, but it is read at start-up only: "
        "restart the node with it"
    )
