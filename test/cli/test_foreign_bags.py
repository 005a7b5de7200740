# SPDX-License-Identifier: Apache-2.0
"""Bags of other kinds through the commands: read, or refused with status 2 and one line."""

from __future__ import annotations

import re
import struct
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
from bag.making import (
    BEGIN_NS,
    FLOAT,
    POINT,
    Channel,
    definition_text,
    float_data,
    point_data,
    write_channels,
)
from bag.recorded import messages
from faults.commands import Ended, ended
from rosbags.highlevel import AnyReader

from fuzzy_fusion_ros.bag import BagMessage
from fuzzy_fusion_ros.cli import replay, score, tune

JOINTS = "sensor_msgs/msg/JointState"
S1_NS = [BEGIN_NS + at * 10_000_000 for at in range(300)]
S2_NS = S1_NS[::10]
COMMANDS: dict[str, Callable[[Sequence[str]], int]] = {
    "replay": replay.main,
    "score": score.main,
    "tune": tune.main,
}


def samples(stamps: Sequence[int]) -> list[tuple[int, bytes]]:
    """Return a slow ramp as PointStamped."""
    return [(ns, point_data(ns, (ns - BEGIN_NS) * 1e-9)) for ns in stamps]


def typed(topic: str, data: Sequence[tuple[int, bytes]], msgtype: str = POINT) -> Channel:
    """Return a channel of one of Jazzy's types."""
    return Channel(topic, data, "cdr", msgtype, "ros2msg", definition_text(msgtype))


S1, S2 = typed("/s1", samples(S1_NS)), typed("/s2", samples(S2_NS))
TRUTH = typed("/truth", samples(S1_NS))


def xcdr2(channel: Channel) -> Channel:
    """Return a channel whose messages are serialised by DDS' second version."""
    return channel._replace(messages=[(ns, b"\0\7" + data[2:]) for ns, data in channel.messages])


def unstamped_joints() -> Channel:
    """Return S2 as a JointState whose stamps are all zero."""
    position = struct.pack("<IIIIIIddII", 0, 0, 1, 0, 0, 2, 1.0, 2.0, 0, 0)
    return typed("/s2", [(ns, b"\0\1\0\0" + position) for ns in S2_NS], JOINTS)


UNREADABLE: dict[str, tuple[list[Channel], str]] = {
    "S1 is JSON": ([S1._replace(encoding="json"), S2], "/s1: .* as 'json', only 'cdr'"),
    "S2 is JSON": ([S1, S2._replace(encoding="json")], "/s2: .* as 'json', only 'cdr'"),
    "all is of ROS 1": (
        [each._replace(encoding="ros1", schema="ros1msg") for each in (S1, S2)],
        "/s1: .* as 'ros1', only 'cdr'",
    ),
    "S1 has no schema": ([S1._replace(msgtype=None), S2], "/s1: .*does not name their type"),
    "definitions are empty": (
        [S1._replace(schema="", text=""), S2._replace(schema="unknown", text="")],
        "/s1: .*described as '', only 'ros2msg' and 'ros2idl'",
    ),
    "S2 is XCDR2": ([S1, xcdr2(S2)], "/s2: .*XCDR2, only plain CDR"),
    "S1 has two types": (
        [S1, typed("/s1", [(ns + 1, float_data(1.0)) for ns in S1_NS], FLOAT), S2],
        "/s1: its messages are of 2 types",
    ),
}


def run(command: str, path: Path, *arguments: str) -> Ended:
    """Run a command; replay writes into a bag named ``out`` beside its input."""
    output = ["--output", str(path.parent / "out")] if command == "replay" else []
    return ended(COMMANDS[command], [str(path), *output, *arguments])


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("case", UNREADABLE)
def test_what_cannot_be_read_is_refused(tmp_path: Path, case: str, command: str) -> None:
    channels, problem = UNREADABLE[case]
    path = write_channels(tmp_path / "bag.mcap", [*channels, TRUTH])
    end = run(command, path)
    assert (end.status, end.stdout, end.stderr.count("\n")) == (2, "", 1)
    assert re.search(problem, end.stderr)


@pytest.mark.parametrize("command", ["score", "tune"])
def test_a_truth_that_cannot_be_read_is_refused(tmp_path: Path, command: str) -> None:
    path = write_channels(tmp_path / "bag.mcap", [S1, S2, TRUTH._replace(encoding="json")])
    end = run(command, path)
    assert end.status == 2
    assert "topic /truth: its messages are serialised as 'json'" in end.stderr


@pytest.mark.parametrize("arguments", [[], ["--s1", "s1"], ["--s1", "/s1", "--s2", "s2"]])
def test_topics_without_a_leading_slash_are_found(tmp_path: Path, arguments: list[str]) -> None:
    channels = [each._replace(topic=each.topic[1:]) for each in (S1, S2, TRUTH)]
    path = write_channels(tmp_path / "bag.mcap", channels)
    assert run("replay", path, *arguments).status == 0
    found = messages(tmp_path / "out")
    assert sum(each.topic == "/estimate" for each in found) == len(S1_NS) - 1
    assert {each.topic for each in found} >= {"s1", "s2", "truth"}
    end = run("score", tmp_path / "out")
    assert end.status == 0
    assert f"{len(S1_NS) - 1} of {len(S1_NS) - 1} estimates matched" in end.stdout


def test_the_estimate_needs_a_message_of_s2_to_be_copied_into(tmp_path: Path) -> None:
    s1 = typed("/s1", samples([BEGIN_NS + at * 10_000_000 for at in range(1000)]))
    path = write_channels(tmp_path / "bag.mcap", [s1, unstamped_joints()])
    end = run("replay", path, "--field", "s2=position[1]")
    assert (end.status, end.stdout, end.stderr.count("\n")) == (2, "", 1)
    assert "gives no estimate: /s2: 30 dropped: stamp is zero" in end.stderr
    assert "there is no message of /s2 to copy the estimate into" in end.stderr


def test_other_topics_are_copied_whatever_they_are(tmp_path: Path) -> None:
    """JSON, two types on a topic, no type at all; the new bag opens in rosbags."""
    strange = [
        typed("/two", [(ns + 1, float_data(1.0)) for ns in S2_NS], FLOAT),
        typed("/two", samples(S2_NS)),
        Channel("/nameless", [(ns, b"?") for ns in S2_NS], "cdr", None),
        Channel("/undescribed", [(ns, b"?") for ns in S2_NS], "cdr", "a_msgs/msg/B", "unknown", ""),
    ]
    json = Channel("/json", [(ns, b"{}") for ns in S2_NS], "json", "x.Y", "jsonschema", "{}")
    path = write_channels(tmp_path / "bag.mcap", [S1, S2, *strange])
    assert run("replay", path).status == 0
    kept = messages(path)
    assert [each for each in messages(tmp_path / "out") if each.topic in topics(kept)] == kept
    with AnyReader([tmp_path / "out"]) as reader:
        assert topics(kept) <= {each.topic for each in reader.connections}
    path = write_channels(tmp_path / "json.mcap", [S1, S2, json])
    end = ended(replay.main, [str(path), "--output", str(tmp_path / "other")])
    assert end.status == 0
    assert "/json: it is serialised as 'json', not as 'cdr'" in end.stderr
    copied = [each for each in messages(tmp_path / "other") if each.topic == "/json"]
    assert [each.data for each in copied] == [b"{}"] * len(S2_NS)


def topics(found: Sequence[BagMessage]) -> set[str]:
    """Return the topics of messages."""
    return {each.topic for each in found}
