# SPDX-License-Identifier: Apache-2.0
"""What nodes record: bytes unchanged, in the order in which they were taken."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest
from bag.making import decoded

from fuzzy_fusion_ros.bag import BagMessage, open_bag
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import EXPLANATION
from fuzzy_fusion_ros.offline.replay import differences, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.ros.qos import OUTPUT
from fuzzy_fusion_ros.ros.recorder import BagRecorder
from fuzzy_fusion_ros.testing import Feed, Harness
from fuzzy_fusion_ros.testing.feed import START_NS


def messages(bag: Path, *topics: str) -> list[BagMessage]:
    with open_bag(bag) as reader:
        assert reader.problems == []
        return list(reader.messages(topics or None))


def stream(feed: Feed) -> None:
    """All that can come in: good, bad, late, looped, of one sensor alone."""
    for loop in range(2):
        for k in range(40):
            feed.send(0.01 * k, s2=math.sin(0.2 * k) if k % 3 == 0 else None)
            feed.send(0.01 * k, s1=math.sin(0.2 * k) + 0.1 * loop)
        feed.publish(feed.s1, Sample(START_NS, math.nan))
        feed.publish(feed.s2, Sample(0, 1.0))
        feed.publish(feed.s1, Sample(START_NS + 10**8, 9.0))
    for k in range(20):
        feed.send(2.0 + 0.5 * k, s2=1.0)
    feed(20.0, s1=1.0)


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_a_recording_of_anything_replays_to_the_same_bytes(
    harness: Harness, tmp_path: Path, trigger: str
) -> None:
    values = {"trigger": trigger, "predictor.enabled": True}
    node = harness.fusion_node({**values, "record": str(tmp_path / "live")})
    stream(harness.feed())
    harness.remove(node)
    with open_bag(tmp_path / "live") as bag:
        replay(bag, tmp_path / "again", Topics(), replace(Parameters(), values))
        assert bag.topics["/estimate"].message_count
    topics = ["/s1", "/s2", "/estimate", *(f"/fusion_node/{name}" for name in EXPLANATION)]
    assert differences(tmp_path / "live", tmp_path / "again", topics) == []


def test_log_times_are_the_nodes_clock_and_causes_come_first(
    harness: Harness, tmp_path: Path
) -> None:
    node = harness.fusion_node({"record": str(tmp_path / "bag")})
    before_ns = node.get_clock().now().nanoseconds
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    after_ns = node.get_clock().now().nanoseconds
    harness.remove(node)
    found = messages(tmp_path / "bag")
    assert [message.topic for message in found[:3]] == ["/s2", "/s1", "/estimate"]
    assert before_ns <= found[0].log_ns <= found[1].log_ns == found[2].log_ns <= after_ns


def test_a_simulations_recordings_repeat_log_times_and_all(tmp_path: Path) -> None:
    bags = []
    for name in ("one", "other"):
        with Harness() as harness:
            bag = tmp_path / name / "bag"
            parameters = {"use_sim_time": True, "trigger": "pair", "record": str(bag)}
            node = harness.fusion_node(parameters)
            feed = harness.feed()
            for k in range(50):
                feed(0.01 * k, s1=math.sin(k), s2=math.sin(k))
            harness.remove(node)
            bags.append(bag)
    one, other = (messages(bag) for bag in bags)
    by_topic = [sorted(each, key=lambda message: message.topic) for each in (one, other)]
    assert by_topic[0] == by_topic[1]


def test_bytes_are_recorded_as_they_came_whatever_their_type(
    harness: Harness, tmp_path: Path
) -> None:
    kind = "sensor_msgs/msg/JointState"
    parameters = {"s1.type": kind, "s1.field": "name=pole:position"}
    node = harness.fusion_node({**parameters, "record": str(tmp_path / "bag")})
    s1 = harness.publisher("/s1", kind)
    harness.spin_until_matched(s1)
    heard = harness.record("/s1", kind)
    message = load_message_class(kind)(name=["wheel"], position=[1.0])  # cannot be read
    s1.publish(message)
    harness.spin_until(lambda: heard)
    feed_one_more = load_message_class(kind)(name=["pole"], position=[2.0])
    feed_one_more.header.stamp.sec = 5
    s1.publish(feed_one_more)
    harness.spin_until(lambda: len(heard) == 2)
    harness.remove(node)
    with open_bag(tmp_path / "bag") as bag:
        names = [list(decoded(each).name) for each in bag.messages(["/s1"])]
        assert bag.topics["/s1"].msgtype == kind
    assert names == [["wheel"], ["pole"]]


def test_an_existing_bag_is_not_overwritten(harness: Harness, tmp_path: Path) -> None:
    (tmp_path / "bag").mkdir()
    (tmp_path / "bag" / "file").write_text("precious")
    with pytest.raises(BagError, match="exists: choose another directory or remove it"):
        harness.fusion_node({"record": str(tmp_path / "bag")})


def test_a_disk_that_fails_ends_the_node_with_one_error(
    harness: Harness, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    harness.fusion_node({"record": str(tmp_path / "bag")})
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)

    def full(*_: object) -> int:
        raise OSError(28, os.strerror(28))

    monkeypatch.setattr("fuzzy_fusion_ros.bag.mcap.writer.McapWriter.flush", full)

    def feed_on() -> None:
        for k in range(1, 5000):
            feed(0.01 * k, s1=1.0, s2=1.0)

    with pytest.raises(BagError, match="cannot be written: No space left on device"):
        feed_on()


def test_log_times_never_run_backwards(tmp_path: Path) -> None:
    recorder = BagRecorder(str(tmp_path / "bag"))
    recorder.add("/x", "std_msgs/msg/Float64", OUTPUT)
    data = b"\x00\x01\x00\x00" + bytes(8)
    for log_ns in (5, 7, -3, 6, 9):
        recorder.write("/x", log_ns, data)
    recorder.close()
    assert [message.log_ns for message in messages(tmp_path / "bag")] == [5, 7, 7, 7, 9]
