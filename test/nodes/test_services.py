# SPDX-License-Identifier: Apache-2.0
"""~/reset, ~/enable and ~/save_parameters."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest
from nodes.test_channels import POINT, START_NS, STEP_NS, point
from nodes.watching import OK, Diagnostics, Log
from std_srvs.srv import SetBool, Trigger

from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.group import flatten
from fuzzy_fusion_ros.self_tuning.choice import MEASURED
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


def test_after_a_reset_no_channel_waits_for_another(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    fields = {f"{axis}.{role}.field": f"point.{axis}" for axis in "xy" for role in ("s1", "s2")}
    node = harness.fusion_node({"channels": ["x", "y"], **fields})
    s1, s2 = (harness.publisher(topic) for topic in ("/s1", "/s2"))
    estimates = harness.record("/estimate", POINT)
    harness.spin_until_matched(s1, s2)

    def send(publisher: Any, stamp_ns: int, values: list[float]) -> None:
        sensor = node.channels[0].s1 if publisher is s1 else node.channels[0].s2
        taken = sensor.subscription.received
        publisher.publish(point(stamp_ns, values))
        harness.spin_until(lambda: sensor.subscription.received > taken)

    send(s2, START_NS, [1.0, 2.0, 0.0])
    send(s1, START_NS, [1.0, 2.0, 0.0])
    harness.spin_until(lambda: len(estimates) == 1)
    assert harness.call(Trigger, "/fusion_node/reset", Trigger.Request()).success
    send(s2, START_NS + STEP_NS, [1.0, 3.0, 0.0])
    send(s1, START_NS + STEP_NS, [1.0, math.nan, 0.0])
    harness.spin_until(lambda: len(estimates) == 2)
    assert [each.point.y for each in estimates] == [2.0, 3.0]
    assert diagnostics.saying("fusion_node: y.fusion", "1 estimates published without this channel")


def test_what_is_not_published_lacks_no_channel(harness: Harness, diagnostics: Diagnostics) -> None:
    fields = {f"{axis}.{role}.field": f"point.{axis}" for axis in "xy" for role in ("s1", "s2")}
    node = harness.fusion_node({"channels": ["x", "y"], **fields})
    s1, s2 = (harness.publisher(topic) for topic in ("/s1", "/s2"))
    harness.spin_until_matched(s1, s2)
    assert harness.call(SetBool, "/fusion_node/enable", SetBool.Request(data=False)).success
    for k in range(20):
        s2.publish(point(START_NS + k * STEP_NS, [1.0, 2.0, 0.0]))
        s1.publish(point(START_NS + k * STEP_NS, [1.0, math.nan, 0.0]))
    harness.spin_until(lambda: node.channels[0].s1.subscription.received == 20)
    diagnostics.next("fusion_node: y.fusion")
    assert not [
        each for each in diagnostics.of("fusion_node: y.fusion") if "without" in each.message
    ]


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


CHANNELS = {"channels": ["x", "y"], "y.s1.field": "point.y", "y.s2.field": "point.y"}


@pytest.mark.parametrize("channels", [{}, CHANNELS], ids=["one scalar", "channels"])
def test_parameters_are_saved_as_given(
    harness: Harness, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, channels: dict[str, Any]
) -> None:
    monkeypatch.chdir(tmp_path)
    node = harness.fusion_node({"gate.tolerance": 0.3, **channels})
    response = harness.call(Trigger, "/fusion_node/save_parameters", Trigger.Request())
    path = tmp_path / "fusion_node_saved.yaml"
    assert (response.success, response.message) == (True, f"parameters written to {path}")
    assert parameters_from(path) == node.parameters


def test_no_file_is_overwritten(
    harness: Harness, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "fusion_node_saved.yaml"
    path.write_text("mine")
    harness.fusion_node()
    response = harness.call(Trigger, "/fusion_node/save_parameters", Trigger.Request())
    assert not response.success
    assert (
        response.message == f"parameter file {str(path)!r}: exists: move it away, then save again"
    )
    assert path.read_text() == "mine"


def test_measured_parameters_are_shown_and_saved_for_a_node_that_does_not_measure(
    harness: Harness, diagnostics: Diagnostics, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    harness.fusion_node({"self_tuning": True})
    feed = harness.feed()
    for k in range(150):
        feed(0.02 * k, s1=math.sin(0.1 * k), s2=math.sin(0.1 * k - 0.3) if k % 3 == 0 else None)
    shown = diagnostics.next("fusion_node: self-tuning").values
    assert set(shown) == set(MEASURED)
    assert harness.call(Trigger, "/fusion_node/save_parameters", Trigger.Request()).success
    saved = parameters_from(tmp_path / "fusion_node_saved.yaml")
    assert not saved.self_tuning
    assert saved.s2.noise > 0.0
    values = flatten(saved)
    assert {name: float(shown[name]) for name in MEASURED} == pytest.approx(
        {name: values[name] for name in MEASURED}, rel=1e-3
    )
