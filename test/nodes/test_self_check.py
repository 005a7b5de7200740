# SPDX-License-Identifier: Apache-2.0
"""What the node finds wrong with its sensors while it runs."""

from __future__ import annotations

import math

import pytest
from nodes.watching import OK, WARN, Diagnostics, Log

from fuzzy_fusion_ros.nodes import self_check
from fuzzy_fusion_ros.testing import Harness

SAMPLES = 2000


def motion(time_s: float) -> float:
    return math.sin(time_s) + math.sin(2.3 * time_s + 1.0) + 0.01 * math.sin(1e6 * time_s)


def feed(harness: Harness, sign: float) -> None:
    """Send 20 s of S1 at 100 Hz and S2 at 20 Hz, 0.2 s late, as fast as they are taken."""
    send = harness.feed()
    for k in range(SAMPLES):
        time_s = 0.01 * k
        s2 = motion(time_s - 0.2) if k % 5 == 0 else None
        send(time_s, s1=sign * motion(time_s), s2=s2)


@pytest.fixture(autouse=True)
def early(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the node check its sensors from the first report on."""
    monkeypatch.setattr(self_check, "FIRST", 1)
    monkeypatch.setattr(self_check, "LONGEST", 1)


def test_a_negated_sensor_is_named_as_check_names_it(
    harness: Harness, diagnostics: Diagnostics, log: Log
) -> None:
    harness.fusion_node()
    feed(harness, -1.0)
    said = diagnostics.saying("fusion_node: check", "s1 has the opposite sign of s2")
    assert said.level == WARN
    assert said.message.endswith("; fix: s1.scale: -1")
    log.wait_for("s1 has the opposite sign of s2")
    diagnostics.next("fusion_node: check")
    assert log.count("s1 has the opposite sign of s2") == 1


def test_of_good_sensors_nothing_is_said(harness: Harness, diagnostics: Diagnostics) -> None:
    harness.fusion_node()
    feed(harness, 1.0)
    for _ in range(2):
        said = diagnostics.next("fusion_node: check")
        assert (said.level, said.message) == (OK, "no problems found")


def test_a_period_in_another_unit_is_said_at_the_start_and_once(
    harness: Harness, diagnostics: Diagnostics, log: Log
) -> None:
    tilt = {"s2.type": "sensor_msgs/msg/Imu", "s2.field": "roll(linear_acceleration)"}
    harness.fusion_node({"signal.period": 360.0, **tilt})
    text = "signal.period is 360, but s2 is in rad, where a turn is 6.283185307179586"
    log.wait_for(text)
    for _ in range(2):
        said = diagnostics.next("fusion_node: check")
        assert said.level == WARN
        assert text in said.message
    assert log.count(text) == 1
