# SPDX-License-Identifier: Apache-2.0
"""The topics that explain each estimate, only while someone listens."""

from __future__ import annotations

from typing import Any

import pytest

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import EXPLANATION, JOINTS, POINT, RULES, TEXT, explain
from fuzzy_fusion_ros.testing import Feed, Harness
from fuzzy_fusion_ros.testing.graph import EVERY_MESSAGE

SCALARS = ("weight", "drift", "aggregate", "prediction", "innovation", "standard_deviation")


def ramp(feed: Feed, start: int, end: int) -> list[float]:
    return [feed(0.01 * k, s1=0.02 * k + 0.1 * (-1) ** k, s2=0.02 * k) for k in range(start, end)]


def test_numbers_behind_each_estimate_are_stamped_as_it_is_and_add_up(harness: Harness) -> None:
    node = harness.fusion_node({"predictor.enabled": True})
    heard = {name: harness.record(f"/fusion_node/{name}") for name in SCALARS}
    strengths = harness.record("/fusion_node/firing_strengths", JOINTS)
    feed = harness.feed()
    harness.spin_until(lambda: node._output.wanted.keys() == EXPLANATION.keys())
    estimates = ramp(feed, 0, 80)
    harness.spin_until(lambda: len(strengths) == len(estimates))
    by_stamp = {
        name: {(m.header.stamp.sec, m.header.stamp.nanosec): m.point.x for m in messages}
        for name, messages in heard.items()
    }
    stamps = list(by_stamp["aggregate"])
    assert len(stamps) == len(estimates)
    assert by_stamp["weight"].keys() == by_stamp["drift"].keys() == by_stamp["aggregate"].keys()
    assert set(by_stamp["standard_deviation"]) <= set(stamps)
    assert min(by_stamp["standard_deviation"].values()) > 0.0
    assert by_stamp["prediction"].keys() == by_stamp["innovation"].keys()
    assert 0 < len(by_stamp["prediction"]) < len(estimates)  # none before it has learnt
    for stamp, estimate, message in zip(stamps, estimates, strengths, strict=True):
        aggregate, prediction = by_stamp["aggregate"][stamp], by_stamp["prediction"].get(stamp)
        if prediction is None:
            assert estimate == aggregate
        else:
            assert estimate in (aggregate, 0.5 * prediction + 0.5 * aggregate)
            assert by_stamp["innovation"][stamp] == aggregate - prediction
        assert (message.header.stamp.sec, message.header.stamp.nanosec) == stamp
        assert sum(message.position) == pytest.approx(1.0)
        assert 0.0 <= by_stamp["weight"][stamp] <= 1.0


def test_firing_strengths_are_labelled_in_the_order_of_table_1(harness: Harness) -> None:
    node = harness.fusion_node({"aggregator.rate_time_constant": 0.0})
    messages = harness.record("/fusion_node/firing_strengths", JOINTS)
    feed = harness.feed()
    harness.spin_until(lambda: node._output.wanted)
    feed(0.0, s1=0.0, s2=0.0)
    feed(0.01, s1=1e6, s2=0.0)  # far apart, S2 at rest
    feed(0.02, s1=1e6, s2=1e6)  # together, S2 on the move
    feed(0.03, s1=-1e6, s2=2e6)
    harness.spin_until(lambda: len(messages) == 4)
    assert [list(message.position) for message in messages] == [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
    assert all(tuple(message.name) == RULES for message in messages)


def test_each_estimate_is_said_in_words(harness: Harness) -> None:
    node = harness.fusion_node({"signal.unit": "rad"})
    sentences = harness.record("/fusion_node/explanation", TEXT)
    feed = harness.feed()
    harness.spin_until(lambda: node.count_subscribers("/fusion_node/explanation") == 1)
    harness.spin_until(lambda: node._output._explanations[""].sentence.wanted)
    estimates = ramp(feed, 0, 3)
    harness.spin_until(lambda: len(sentences) == 3)
    for estimate, sentence in zip(estimates, sentences, strict=True):
        assert sentence.data.startswith(f"The estimate {estimate:.6g} rad is ")
        assert "aggregator.weight." in sentence.data


def test_listeners_that_come_and_go_are_told_apart(harness: Harness) -> None:
    node = harness.fusion_node()
    feed = harness.feed()
    name = "/fusion_node/weight"
    point = load_message_class(POINT)

    def heard_by(listeners: int, k: int) -> None:
        heard: list[object] = []
        subscriptions = [
            harness.node.create_subscription(point, name, heard.append, EVERY_MESSAGE)
            for _ in range(listeners)
        ]
        harness.spin_until(lambda: node.count_subscribers(name) == listeners)
        harness.spin_until(lambda: node._output.wanted)
        harness.spin_until(lambda: all(each.get_publisher_count() for each in subscriptions))
        for subscription in subscriptions[1:]:  # one of them goes: the other still listens
            harness.node.destroy_subscription(subscription)
        harness.spin_until(lambda: node.count_subscribers(name) == 1)
        ramp(feed, k, k + 3)
        harness.spin_until(lambda: len(heard) == 3)
        harness.node.destroy_subscription(subscriptions[0])
        harness.spin_until(lambda: not node._output.wanted, "nobody listens")
        ramp(feed, k + 3, k + 6)
        assert len(heard) == 3

    for k, listeners in enumerate((1, 2, 1)):
        heard_by(listeners, 6 * k)


def test_nothing_is_made_while_nobody_listens(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []
    original = explain

    def counted(*arguments: Any) -> Any:
        made.append("once")
        return original(*arguments)

    monkeypatch.setattr("fuzzy_fusion_ros.nodes.estimates.explain", counted)
    node = harness.fusion_node()
    feed = harness.feed()
    ramp(feed, 0, 5)
    assert made == []
    weights = harness.record("/fusion_node/weight")
    harness.spin_until(lambda: node._output.wanted)
    ramp(feed, 5, 8)
    harness.spin_until(lambda: len(weights) == 3)
    assert made == ["once"] * 3
