# SPDX-License-Identifier: Apache-2.0
"""Recorded messages, played onto topics."""

from __future__ import annotations

import itertools
import signal
from pathlib import Path
from typing import Any

import pytest
from bag.making import FLOAT, decoded, float_data
from bag.recorded import Scalar, at, messages, swing, write_scalars
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from fuzzy_fusion_ros.bag import BagMessage, BagWriter, Definition, offered_qos, open_bag
from fuzzy_fusion_ros.cli.replay import main
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.graph import EVERY_MESSAGE

SECONDS = 1.0


def stamps(found: list[Any]) -> list[int]:
    """Return the stamps of messages, ns."""
    return [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in found]


def clocks(found: list[Clock]) -> list[int]:
    """Return times, ns."""
    return [each.clock.sec * 10**9 + each.clock.nanosec for each in found]


def played(harness: Harness, *arguments: str) -> int:
    """Play beside this process's graph; return the status."""
    player = harness.start("replay", *arguments, "--live")
    harness.spin_until(lambda: player.status is not None, "the end of playing")
    assert all("use_sim_time:=true" in line for line in player.stderr.splitlines())
    return player.wait()


def settle(harness: Harness, found: list[Any], count: int) -> None:
    """Run until so many messages have come."""
    harness.spin_until(lambda: len(found) >= count, f"{count} messages, {len(found)} have come")


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A short bag with everything, also explanations."""
    weights = [Scalar("/fusion_node/weight", 0.0, 0.5, log_s=0.5)]
    return write_scalars(tmp_path / "bag", [*swing(SECONDS), *weights])


def test_messages_come_out_as_they_are(harness: Harness, bag: Path) -> None:
    s1, s2, truth = (harness.record(f"/{name}") for name in ("s1", "s2", "truth"))
    estimate, weight = harness.record("/estimate"), harness.record("/fusion_node/weight")
    assert played(harness, str(bag), "--rate", "10") == 0
    settle(harness, truth, 100)
    assert stamps(s1) == [each.log_ns for each in messages(bag, ["/s1"])]
    assert len(s2) == 10
    assert [each.point.x for each in s2][:3] == [0.0, 0.0, pytest.approx(0.09)]
    assert estimate == weight == []


def test_bytes_come_out_as_they_were_recorded(harness: Harness, tmp_path: Path) -> None:
    kind = "sensor_msgs/msg/JointState"
    joints = [
        serialize_message(load_message_class(kind)(name=k * ["a joint"], effort=k * [1.0]))
        for k in range(5)
    ]
    strange = [*joints, joints[-1] + b"more", joints[-1][:9]]  # not for a player to judge
    with BagWriter(tmp_path / "bag") as writer:
        for k, data in enumerate(strange):
            for topic in ("/s1", "/s2"):
                writer.write(topic, FLOAT, at(0.01 * k), float_data(k))
            writer.write("/joints", kind, at(0.01 * k), data)
    heard: list[bytes] = []
    harness.node.create_subscription(
        load_message_class(kind), "/joints", heard.append, EVERY_MESSAGE, raw=True
    )
    harness.record("/s1", FLOAT)
    harness.record("/s2", FLOAT)
    assert played(harness, str(tmp_path / "bag")) == 0
    settle(harness, heard, len(strange))
    assert [each[: len(data)] for each, data in zip(heard, strange, strict=True)] == strange


def test_the_rate_is_that_of_time(harness: Harness, tmp_path: Path) -> None:
    hour = [Scalar(topic, time_s, 0.0) for time_s in (0.0, 3600.0) for topic in ("/s1", "/s2")]
    s1 = harness.record("/s1")
    harness.record("/s2")
    path = str(write_scalars(tmp_path / "bag", hour))
    assert played(harness, path, "--rate", "3600") == 0  # at any other it would not end in time
    settle(harness, s1, 2)


def test_the_clock_follows_the_recording(harness: Harness, bag: Path) -> None:
    harness.record("/s1")
    harness.record("/s2")
    clock = harness.record("/clock", "rosgraph_msgs/msg/Clock")
    assert played(harness, str(bag), "--start", "0.2", "--end", "0.5") == 0
    settle(harness, clock, 30)
    times = clocks(clock)
    assert times == sorted(set(times))
    assert (times[0], times[-1]) == (at(0.2), at(0.49))


def test_the_clock_goes_on_through_a_silence(harness: Harness, tmp_path: Path) -> None:
    ends = [Scalar(topic, time_s, 0.0) for time_s in (0.0, 1.0) for topic in ("/s1", "/s2")]
    harness.record("/s1")
    harness.record("/s2")
    clock = harness.record("/clock", "rosgraph_msgs/msg/Clock")
    assert played(harness, str(write_scalars(tmp_path / "bag", ends))) == 0
    harness.spin_until(lambda: clock and clocks(clock)[-1] == at(1.0), "the last time")
    assert len(clock) > 5
    assert clocks(clock) == sorted(clocks(clock))


def test_a_node_that_listens_gives_what_a_replay_gives(
    harness: Harness, bag: Path, tmp_path: Path
) -> None:
    paired = write_scalars(
        tmp_path / "paired", [each for each in swing(SECONDS) if each.topic != "/estimate"]
    )
    harness.fusion_node(
        {"trigger": "pair", "use_sim_time": True, "predictor.enabled": True},
    )
    found = harness.record("/estimate")
    assert played(harness, str(paired), "--rate", "5") == 0
    settle(harness, found, 10)
    params = tmp_path / "params.yaml"
    params.write_text(
        "fusion_node:\n  ros__parameters:\n    trigger: pair\n    predictor.enabled: true\n"
    )
    arguments = ["--params", str(params), "--output", str(tmp_path / "out")]
    assert main([str(paired), *arguments]) == 0
    with open_bag(tmp_path / "out") as replayed:
        expected = [decoded(each).point.x for each in replayed.messages(["/estimate"])]
    assert [each.point.x for each in found] == expected


@pytest.mark.parametrize(
    "number",
    [signal.SIGINT, pytest.param(signal.SIGTERM, marks=pytest.mark.slow("as SIGINT"))],
)
def test_a_loop_goes_on_until_it_is_told_to_stop(
    harness: Harness, bag: Path, number: signal.Signals
) -> None:
    s1 = harness.record("/s1")
    harness.record("/s2")
    clock = harness.record("/clock", "rosgraph_msgs/msg/Clock")
    player = harness.start("replay", str(bag), "--live", "--loop", "--rate", "20")
    settle(harness, s1, 250)
    player.send(number)
    assert player.wait() == 0
    assert player.stderr.count("\n") == 1  # on the rate
    assert stamps(s1)[:200] == 2 * [each.log_ns for each in messages(bag, ["/s1"])]
    times = clocks(clock)
    backs = [(before, now) for before, now in itertools.pairwise(times) if now < before]
    assert backs[:2] == 2 * [(at(0.99), at(0.0))]


@pytest.mark.parametrize("rate", [1.0, 10.0])
def test_at_another_rate_the_clock_of_timeouts_is_named(
    harness: Harness, bag: Path, rate: float
) -> None:
    for topic in ("/s1", "/s2"):
        harness.record(topic)
    player = harness.start("replay", str(bag), "--live", "--rate", str(rate))
    harness.spin_until(lambda: player.status is not None, "the end of playing")
    assert ("use_sim_time:=true" in player.stderr) == (rate != 1.0)


def test_types_that_are_not_installed_are_left_out(harness: Harness, tmp_path: Path) -> None:
    secret = BagMessage("/secret", "my_msgs/msg/Secret", at(0.5), b"\0\1\0\0whatever")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic(secret.topic, secret.msgtype, definition=Definition("unknown", ""))
        for k in range(20):
            for topic in ("/s1", "/s2"):
                writer.write(topic, FLOAT, at(k * 0.01), float_data(k))
        writer.write(*secret)
    found = harness.record("/s1", FLOAT)
    harness.record("/s2", FLOAT)
    player = harness.start("replay", str(tmp_path / "bag"), "--live")
    settle(harness, found, 20)
    assert player.wait() == 0
    assert "/secret is skipped: message type 'my_msgs/msg/Secret' is not" in player.stderr
    assert player.stdout == "40 messages published\n"


def test_best_effort_stays_best_effort(harness: Harness, tmp_path: Path) -> None:
    profile = offered_qos(reliability="best_effort", durability="transient_local")
    with BagWriter(tmp_path / "bag") as writer:
        writer.add_topic("/s1", FLOAT, qos=[profile])
        for k in range(200):
            for topic in ("/s1", "/s2"):
                writer.write(topic, FLOAT, at(k * 0.01), float_data(k))
    s2 = harness.record("/s2", FLOAT)
    player = harness.start("replay", str(tmp_path / "bag"), "--live", "--loop")
    harness.spin_until(lambda: harness.node.count_publishers("/s1"), "a publisher")
    (offered,) = harness.node.get_publishers_info_by_topic("/s1")
    assert offered.qos_profile.reliability.name == "BEST_EFFORT"
    assert offered.qos_profile.durability.name == "TRANSIENT_LOCAL"
    assert s2 == []  # it waits for a subscriber of S1
    player.send(signal.SIGINT)
    assert player.wait() == 130
    assert player.stderr.startswith("replay: interrupted: nobody subscribes to /s1")


def test_nothing_to_play_is_refused(harness: Harness, tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        for topic in ("/s1", "/s2"):
            writer.add_topic(topic, "my_msgs/msg/X", definition=Definition("unknown", ""))
            writer.write(topic, "my_msgs/msg/X", at(0.0), b"\0\1\0\0")
    player = harness.start("replay", str(tmp_path / "bag"), "--live")
    assert player.wait() == 2
    assert "/s1 is skipped: message type 'my_msgs/msg/X' is not installed" in player.stderr
    assert player.stderr.count("\n") == 1
