# SPDX-License-Identifier: Apache-2.0
"""The public harness: a graph of its own, and nothing left behind."""

from __future__ import annotations

import functools
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from faults.waiting import wait_until
from rclpy.qos import QoSProfile
from std_msgs.msg import Empty
from std_srvs.srv import Trigger

from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.nodes.pendulum_node import PeerError, PendulumNode
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.testing import Harness, claimed_domain
from fuzzy_fusion_ros.testing.domain import DOMAINS


def test_graphs_do_not_hear_each_other() -> None:
    with Harness() as one, Harness() as other:
        assert one.domain_id != other.domain_id
        feeds = []
        for harness in (one, other):
            harness.fusion_node({"trigger": "pair"})
            feeds.append(harness.feed())
        for value, feed in enumerate(feeds):
            assert feed(0.0, s1=float(value), s2=float(value)) == value
        assert [len(feed.estimates) for feed in feeds] == [1, 1]


def test_a_closed_graph_is_silent_even_if_someone_keeps_it() -> None:
    kept: list[object] = []
    for value in (1.0, 2.0, 3.0):
        with Harness() as harness:
            node = harness.fusion_node()
            feed = harness.feed()
            late = harness.record("/estimate", qos=ESTIMATE)
            assert feed(0.0, s1=value, s2=value) == value
            kept += [harness, node, feed]
            harness.spin_until(functools.partial(bool, late))
            assert [message.point.x for message in late] == [value]


def test_a_removed_node_makes_room_for_one_of_its_name() -> None:
    with Harness() as harness:
        log = harness.record("/rosout", "rcl_interfaces/msg/Log")

        def is_heard(text: str) -> bool:
            return text in [message.msg for message in log]

        for k in range(3):
            node = harness.fusion_node()
            harness.spin_until(lambda: harness.node.count_publishers("/rosout"))
            node.log.info(f"{k} is heard")
            harness.spin_until(functools.partial(is_heard, f"{k} is heard"))
            harness.remove(node)


def test_a_removed_node_does_nothing_more_although_its_timers_are_due() -> None:
    with Harness() as harness:
        node = harness.fusion_node()
        publisher = node.create_publisher(Empty, "due", 1)
        ticks: list[int] = []

        def tick() -> None:
            publisher.publish(Empty())
            ticks.append(1)

        timers = [node.create_timer(1e-3, tick) for _ in range(4)]
        harness.spin_until(lambda: ticks)
        ticks.clear()
        wait_until(lambda: all(each.is_ready() for each in timers), "all timers due")
        harness.spin_until(lambda: ticks)
        harness.remove(node)


def test_the_environment_is_put_back() -> None:
    before = dict(os.environ)
    with Harness() as harness:
        assert os.environ["ROS_DOMAIN_ID"] == str(harness.domain_id)
        assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert dict(os.environ) == before


def test_waiting_has_an_end_and_says_for_what() -> None:
    with Harness() as harness:
        with pytest.raises(TimeoutError, match=r"waited 0\.1 s for a wonder"):
            harness.spin_until(lambda: False, "a wonder", timeout=0.1)
        harness.spin_until(lambda: True, timeout=0.0)


def test_a_node_that_refuses_or_gives_up_is_heard() -> None:
    with Harness() as harness:
        with pytest.raises(ParameterError):
            harness.fusion_node({"gate.tolerance": -1.0})

        def give_up() -> None:
            harness.add(PendulumNode, {"timeout": 0.05})  # on a busy machine, in here already
            harness.spin_until(lambda: False)

        with pytest.raises(PeerError):
            give_up()


def test_a_feed_without_a_node_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Harness.spin_until, "__defaults__", ("", 0.1))
    with Harness() as harness, pytest.raises(TimeoutError, match="subscriptions to /s1"):
        harness.feed()


def test_a_feed_takes_other_types_topics_and_fields() -> None:
    kind = "sensor_msgs/msg/Temperature"
    with Harness() as harness:
        parameters = {"s1.type": kind, "s2.type": kind}
        remaps = ("-r", "s1:=/fast", "-r", "s2:=/slow", "-r", "estimate:=/best")
        harness.fusion_node(parameters, arguments=remaps)
        topics = {"s1": "/fast", "s2": "/slow", "estimate": "/best"}
        feed = harness.feed(**topics, type_name=kind, field="temperature")
        assert feed(0.0, s1=20.0, s2=20.0) == 20.0


def test_a_child_process_meets_the_graph_and_is_ended_with_it() -> None:
    with Harness() as harness:
        child = harness.start("fusion_node", "--ros-args", "-p", "trigger:=pair", "-p", RELIABLE)
        feed = harness.feed()
        assert feed(0.0, s1=1.5, s2=1.5) == 1.5
        assert harness.call(Trigger, "/fusion_node/reset", Trigger.Request()).success
        assert child.status is None
        assert "FUSED: both sensors" in child.stderr
        pid = child.pid
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


RELIABLE = "qos:=reliable"


def test_a_child_process_tells_how_it_ended() -> None:
    with Harness() as harness:
        child = harness.start("fusion_node", "--help")
        assert child.wait() == 0
        assert child.stdout.startswith("usage: fuzzy-fusion fusion_node")
        with harness.start("fusion_node") as other:
            harness.spin_until(lambda: harness.node.count_publishers("/estimate"))
            with pytest.raises(TimeoutError, match=r"still running after 0\.0 s"):
                other.wait(0.0)
            other.send(signal.SIGINT)
            assert other.wait() == 0


def test_a_recording_hears_reliable_publishers_whole() -> None:
    with Harness() as harness:
        publisher = harness.publisher("/x", "std_msgs/msg/Int32", QoSProfile(depth=2000))
        heard = harness.record("/x", "std_msgs/msg/Int32")
        harness.spin_until_matched(publisher)
        kind = load_message_class("std_msgs/msg/Int32")
        for k in range(1000):
            publisher.publish(kind(data=k))
        harness.spin_until(lambda: len(heard) == 1000)
        assert [message.data for message in heard] == list(range(1000))


def test_domains_are_claimed_once_and_given_back() -> None:
    with claimed_domain() as one, claimed_domain() as other:
        assert one != other
        assert {one, other} <= set(DOMAINS)
    with claimed_domain() as again:
        assert again == one


def test_other_processes_respect_the_claim() -> None:
    program = "from fuzzy_fusion_ros.testing.domain import *\nwith claimed_domain() as d: print(d)"
    with claimed_domain() as mine:
        done = subprocess.run(
            [sys.executable, "-c", f"import os; os.getpid = lambda: {os.getpid()}\n{program}"],
            capture_output=True,
            text=True,
            check=True,
            cwd=Path(__file__).parents[2],
        )
        assert int(done.stdout) != mine


def test_when_all_domains_are_claimed_it_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    with claimed_domain() as mine:
        monkeypatch.setattr("fuzzy_fusion_ros.testing.domain.DOMAINS", range(mine, mine + 1))
        with pytest.raises(RuntimeError, match="are all claimed"), claimed_domain():
            pass
