"""~/reset and ~/enable."""

from __future__ import annotations

from nodes.watching import OK, Diagnostics, Log
from std_srvs.srv import SetBool, Trigger

from fuzzy_fusion_ros.testing import Feed, Harness


def ramp(feed: Feed) -> list[float]:
    return [feed(0.01 * k, s1=0.01 * k, s2=0.01 * k) for k in range(60)]


def test_reset_forgets_all(harness: Harness) -> None:
    harness.fusion_node({"predictor.enabled": True})
    feed = harness.feed()
    first = ramp(feed)
    response = harness.call(Trigger, "/fusion_node/reset", Trigger.Request())
    assert (response.success, response.message) == (True, "state cleared")
    assert ramp(feed) == first  # the same stamps again: they count as new


def test_disabled_publishes_nothing_and_enabled_goes_on_at_once(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    response = harness.call(SetBool, "/fusion_node/enable", SetBool.Request(data=False))
    assert response.success
    assert "disabled" in response.message
    feed.send(0.01, s1=1.0, s2=1.0)
    status = diagnostics.saying("fusion_node: fusion", "DISABLED")
    assert (status.level, status.values["mode"]) == (OK, "DISABLED")
    assert harness.call(SetBool, "/fusion_node/enable", SetBool.Request(data=True)).success
    assert feed(0.02, s1=1.0, s2=1.0) == 1.0
    assert len(feed.estimates) == 2
    assert diagnostics.next("fusion_node: fusion").values["mode"] == "FUSED"


def test_enabled_twice_is_no_change_of_mode(
    harness: Harness, diagnostics: Diagnostics, log: Log
) -> None:
    node = harness.fusion_node({"s1.timeout": 1000.0})
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    assert harness.call(SetBool, "/fusion_node/enable", SetBool.Request(data=True)).success
    assert diagnostics.next("fusion_node: fusion").values["mode"] == "FUSED"
    node.log.info("the last line")
    log.wait_for("the last line")
    assert log.count("FUSED: ") == 1
    assert log.count("WAITING: ") == 1


def test_services_follow_the_nodes_name(harness: Harness) -> None:
    harness.fusion_node(arguments=("-r", "__node:=fuser", "-r", "__ns:=/robot"))
    assert harness.call(Trigger, "/robot/fuser/reset", Trigger.Request()).success
