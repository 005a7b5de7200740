# SPDX-License-Identifier: Apache-2.0
"""Time that jumps, loops, pauses or leaves gaps."""

from __future__ import annotations

import math
from typing import Any

import pytest
from nodes.watching import Diagnostics, Log
from rclpy.publisher import Publisher

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.testing import Feed, Harness
from fuzzy_fusion_ros.testing.feed import START_NS

CLOCK = "rosgraph_msgs/msg/Clock"
PREDICTOR = pytest.mark.parametrize("predictor", [False, True], ids=["FA alone", "FA and FP"])


def once_through(feed: Feed, samples: int) -> list[float]:
    """Feed the same stretch of a signal, from its start."""
    signal = [math.sin(0.2 * k) for k in range(samples)]
    return [feed(0.01 * k, s1=x + 0.1 * (-1) ** k, s2=x) for k, x in enumerate(signal)]


class SimulatedClock:
    """Publishes /clock."""

    def __init__(self, harness: Harness) -> None:
        self._harness = harness
        self._publisher: Publisher = harness.publisher("/clock", CLOCK)

    def set(self, node: Any, at: float) -> None:
        """Set the clock, in seconds of a feed, and wait until a node has it."""
        stamp_ns = START_NS + round(at * SECOND_NS)
        message = load_message_class(CLOCK)()
        message.clock.sec, message.clock.nanosec = divmod(stamp_ns, SECOND_NS)
        self._harness.spin_until_matched(self._publisher)
        self._publisher.publish(message)
        self._harness.spin_until(lambda: node.get_clock().now().nanoseconds == stamp_ns)


@PREDICTOR
@pytest.mark.parametrize("samples", [6, 60, 150], ids=["short", "medium", "past the timeout"])
def test_a_looped_bag_gives_the_same_estimates_each_time(
    harness: Harness, log: Log, samples: int, predictor: bool
) -> None:
    harness.fusion_node({"trigger": "pair", "predictor.enabled": predictor})
    feed = harness.feed()
    first = once_through(feed, samples)
    assert [once_through(feed, samples) for _ in range(2)] == [first, first]
    log.wait_for("timestamps jumped back: state cleared, restarting")


def test_a_looped_bag_with_its_clock_does_too(harness: Harness, log: Log) -> None:
    node = harness.fusion_node({"trigger": "pair", "use_sim_time": True})
    clock = SimulatedClock(harness)
    feed = harness.feed()
    loops = []
    for _ in range(3):
        clock.set(node, 0.0)
        loops.append(once_through(feed, 40))
        clock.set(node, 0.4)
    assert loops[1:] == [loops[0], loops[0]]
    log.wait_for("timestamps jumped back: state cleared, restarting")


def test_many_restarts_are_not_all_logged(harness: Harness, log: Log) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    for _ in range(30):
        once_through(feed, 6)
    log.wait_for("timestamps jumped back: state cleared, restarting")
    assert log.count("timestamps jumped back") < 15


@pytest.mark.parametrize("told", [0.2, 0.1], ids=["level with the samples", "behind them"])
def test_a_clock_that_comes_late_does_not_clear_what_has_begun_anew(
    harness: Harness, log: Log, told: float
) -> None:
    node = harness.fusion_node({"trigger": "pair", "use_sim_time": True})
    clock = SimulatedClock(harness)
    feed = harness.feed()
    clock.set(node, 0.0)
    first = once_through(feed, 40)
    clock.set(node, 0.4)
    again = once_through(feed, 20)
    clock.set(node, told)
    signal = [math.sin(0.2 * k) for k in range(40)]
    rest = range(20, 40)
    again += [feed(0.01 * k, s1=signal[k] + 0.1 * (-1) ** k, s2=signal[k]) for k in rest]
    assert again == first
    log.wait_for("timestamps jumped back")
    assert log.count("timestamps jumped back") == 1


def test_estimates_go_on_at_once_when_the_clock_jumps_back_or_ahead(harness: Harness) -> None:
    node = harness.fusion_node({"trigger": "pair", "use_sim_time": True})
    clock = SimulatedClock(harness)
    feed = harness.feed()
    for at in (100.0, 5.0, 7000.0, 0.0):
        clock.set(node, at)
        assert feed(at, s1=1.0, s2=1.0) == 1.0


def test_a_simulation_whose_clock_has_not_come_yet_is_fused(harness: Harness) -> None:
    harness.fusion_node({"use_sim_time": True})
    feed = harness.feed()
    assert feed(1e6, s1=1.0, s2=1.0) == 1.0


def test_far_future_is_measured_by_the_simulated_clock(harness: Harness) -> None:
    node = harness.fusion_node({"trigger": "pair", "use_sim_time": True})
    clock = SimulatedClock(harness)
    feed = harness.feed()
    clock.set(node, 0.0)
    feed.send(10.5, s1=1.0, s2=1.0)
    assert feed(0.0, s1=2.0, s2=2.0) == 2.0
    assert [sample.value for sample in feed.estimates] == [2.0]


def test_a_paused_simulation_is_not_stale(harness: Harness, diagnostics: Diagnostics) -> None:
    parameters = {"use_sim_time": True, "s1.timeout": 0.1, "s2.timeout": 0.1}
    node = harness.fusion_node(parameters)
    clock = SimulatedClock(harness)
    feed = harness.feed()
    clock.set(node, 0.0)
    feed(0.0, s1=1.0, s2=1.0)
    for _ in range(2):
        assert diagnostics.next("fusion_node: fusion").values["mode"] == "FUSED"
    clock.set(node, 5.0)
    assert diagnostics.next("fusion_node: fusion").values["mode"] == "STALE"


def test_diagnostics_go_on_when_the_clock_steps_back(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    node = harness.fusion_node({"use_sim_time": True})
    clock = SimulatedClock(harness)
    clock.set(node, 1e6)
    diagnostics.next("fusion_node: fusion")
    clock.set(node, 1.0)
    for _ in range(2):
        diagnostics.next("fusion_node: fusion")


def test_silence_is_counted_from_when_the_clock_stepped_back(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    """Not from the last sample, whose time has yet to come again."""
    node = harness.fusion_node({"use_sim_time": True})
    clock = SimulatedClock(harness)
    feed = harness.feed()

    def age(at: float) -> float:
        clock.set(node, at)
        return float(diagnostics.next("fusion_node: s1").values["age (s)"])

    clock.set(node, 100.0)
    feed(100.0, s1=1.0, s2=1.0)
    assert [age(at) for at in (101.0, 5.0, 7.0)] == [1.0, 0.0, 2.0]


def test_ticks_go_on_when_the_clock_steps_back(harness: Harness) -> None:
    node = harness.fusion_node({"use_sim_time": True, "trigger": "timer", "rate": 50.0})
    clock = SimulatedClock(harness)
    feed = harness.feed()
    for at in (1e6, 1.0):
        clock.set(node, at)
        assert feed(at, s1=1.0, s2=1.0) == 1.0


@PREDICTOR
def test_a_long_gap_makes_no_spike(harness: Harness, predictor: bool) -> None:
    harness.fusion_node({"predictor.enabled": predictor})
    feed = harness.feed()
    for k in range(100):  # a steep ramp, so that rate, drift and predictor are in full swing
        feed(0.01 * k, s1=0.05 * k, s2=0.05 * k)
    assert feed(100.0, s1=-3.0, s2=-3.0) == -3.0
    assert feed(100.01, s1=-3.0, s2=-3.0) == -3.0


def test_stamps_before_1970_or_at_the_end_of_time_break_nothing(harness: Harness) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    for stamp_ns in (-5 * SECOND_NS, (2**31 - 1) * SECOND_NS):
        for publisher in (feed.s2, feed.s1):
            feed.publish(publisher, Sample(stamp_ns, 1.0))
    assert feed(0.0, s1=1.0, s2=1.0) == 1.0
