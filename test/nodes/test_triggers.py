# SPDX-License-Identifier: Apache-2.0
"""When an estimate comes: at S1, at pairs, at ticks; whatever the rates."""

from __future__ import annotations

import random
from typing import Any

import pytest
from nodes.watching import Diagnostics
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.testing import Feed, Harness
from fuzzy_fusion_ros.testing.feed import START_NS


def test_s1_gives_an_estimate_at_each_s1_with_s2_held(harness: Harness) -> None:
    harness.fusion_node()
    feed = harness.feed()
    stamps = [feed.send(0.0, s1=1.0, s2=1.0)]
    for k in range(1, 6):
        feed(0.01 * k, s1=1.0)
        stamps.append(START_NS + 10_000_000 * k)
    feed.send(0.06, s2=1.0)
    feed(0.07, s1=1.0)
    stamps.append(START_NS + 70_000_000)
    assert [sample.stamp_ns for sample in feed.estimates] == stamps


def by_the_core(
    parameters: dict[str, Any], samples: list[tuple[float, float, float | None]]
) -> list[Sample]:
    """What comes out without ROS: of each time, S2 and then S1."""
    fusion = Fusion(replace(Parameters(), parameters))
    out: list[Fused] = []
    for at, s1, s2 in samples:
        stamp_ns = START_NS + round(at * 1e9)
        if s2 is not None:
            out += fusion.on_s2(Sample(stamp_ns, s2)).estimates
        out += fusion.on_s1(Sample(stamp_ns, s1)).estimates
    return [Sample(fused.stamp_ns, fused.estimate.value) for fused in out]


@pytest.mark.parametrize("lag", [0, 1, 3])
@pytest.mark.parametrize("late", ["s1", "s2"])
def test_pair_gives_the_same_whatever_the_order_of_arrival(
    harness: Harness, late: str, lag: int
) -> None:
    samples: list[Any] = [(0.01 * k, 1.0 - k, 2.0 + 3.0 * k) for k in range(8)]
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    early = "s2" if late == "s1" else "s1"
    for k in range(len(samples) + lag):
        for sensor, index in ((early, k), (late, k - lag)):
            if 0 <= index < len(samples):
                at, s1, s2 = samples[index]
                feed.send(at, **{sensor: s1 if sensor == "s1" else s2})
    until(harness, feed, len(samples))
    assert feed.estimates == by_the_core({"trigger": "pair"}, samples)


def test_pair_waits_for_the_partner(harness: Harness, diagnostics: Diagnostics) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    feed.send(0.0, s1=1.0)
    feed.send(0.01, s1=1.0)
    feed.send(0.02, s1=1.0)
    feed.send(0.01, s2=1.0)
    harness.spin_until(lambda: feed.estimates)
    feed.send(0.02, s2=1.0)
    harness.spin_until(lambda: len(feed.estimates) == 2)
    wanted = [START_NS + 10_000_000, START_NS + 20_000_000]
    assert [sample.stamp_ns for sample in feed.estimates] == wanted
    status = diagnostics.saying("fusion_node: s1", "no partner with an equal stamp")
    assert status.values["dropped: no partner with an equal stamp"] == "1"


def until(harness: Harness, feed: Feed, estimates: int) -> None:
    harness.spin_until(lambda: len(feed.estimates) >= estimates, f"{estimates} estimates")


def test_timer_gives_the_newest_at_its_rate_and_nothing_without_a_new_s1(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "timer", "rate": 5.0})
    feed = harness.feed()
    feed.send(0.0, s2=1.0)
    for k in range(10):
        feed.send(0.01 * k, s1=1.0)
    until(harness, feed, 1)
    feed.send(0.2, s1=1.0)
    harness.spin_until(lambda: feed.estimates[-1].stamp_ns == START_NS + 200_000_000)
    count = len(feed.estimates)
    assert count <= 3  # 11 samples, two bursts: at most two ticks fell into one
    diagnostics.next("fusion_node: fusion")  # ticks go on
    assert len(feed.estimates) == count


def test_the_timers_rate_can_be_changed(harness: Harness) -> None:
    harness.fusion_node({"trigger": "timer", "rate": 0.001})
    feed = harness.feed()
    feed.send(0.0, s1=1.0, s2=1.0)
    request = SetParameters.Request(parameters=[Parameter("rate", value=500.0).to_parameter_msg()])
    (result,) = harness.call(SetParameters, "fusion_node/set_parameters", request).results
    assert result.successful
    until(harness, feed, 1)


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_irregular_changing_rates_are_what_the_core_makes_of_them(
    harness: Harness, trigger: str
) -> None:
    """Jitter, S2 six times slower, a pause: the same as without ROS, to the last bit."""
    generator = random.Random(5)
    samples: list[tuple[float, float, float | None]] = []
    at = 0.0
    for k in range(120):
        at += generator.choice((0.001, 0.01, 0.013, 0.2)) if k != 60 else 3.0
        s2 = 0.01 * k if trigger == "pair" or k % 6 == 0 else None
        samples.append((at, generator.gauss(0.0, 0.1), s2))
    parameters = {"trigger": trigger, "predictor.enabled": True}
    harness.fusion_node(parameters)
    feed = harness.feed()
    for sample in samples:
        feed(*sample)
    assert feed.estimates == by_the_core(parameters, samples)
