# SPDX-License-Identifier: Apache-2.0
"""What the node finds wrong with its sensors while it runs."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from typing import Any

import pytest
from nodes.watching import OK, WARN, Diagnostics, Log

from fuzzy_fusion_ros.checking.check import Check
from fuzzy_fusion_ros.checking.recent import check_recent
from fuzzy_fusion_ros.nodes import self_check
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.graph import TIMEOUT

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


class Held:
    """Checks that wait to be let go, except in the thread that serves the node."""

    def __init__(self) -> None:
        self.go_on = threading.Event()
        self.threads: list[threading.Thread] = []

    def __call__(self, *arguments: Any) -> Check:
        self.threads.append(threading.current_thread())
        if self.threads[-1] is not threading.main_thread():
            self.go_on.wait()
        return check_recent(*arguments)


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch, harness: Harness) -> Iterator[Held]:
    checks = Held()
    monkeypatch.setattr(self_check, "check_recent", checks)
    yield checks
    checks.go_on.set()


def test_estimates_go_on_during_a_check(
    harness: Harness, diagnostics: Diagnostics, held: Held
) -> None:
    harness.fusion_node()
    harness.spin_until(lambda: held.threads, "a check")
    feed(harness, -1.0)
    assert diagnostics.next("fusion_node: check").message == "no problems found"
    assert len(held.threads) == 1
    assert held.threads[0] is not threading.main_thread()
    held.go_on.set()
    diagnostics.saying("fusion_node: check", "s1 has the opposite sign of s2")


def test_channels_are_checked_one_after_the_other(
    harness: Harness, diagnostics: Diagnostics, held: Held
) -> None:
    fields = {f"y.{each}.field": "point.y" for each in ("s1", "s2", "estimate")}
    harness.fusion_node({"channels": ["x", "y"], **fields})
    for channel in "xy":
        diagnostics.next(f"fusion_node: {channel}.check")
    assert len(held.threads) == 1
    held.go_on.set()
    harness.spin_until(lambda: len(held.threads) > 1, "the check of the other channel")
    assert held.threads[1] is held.threads[0]


def test_a_node_closes_during_a_check_and_the_thread_ends_with_it(
    harness: Harness, held: Held
) -> None:
    node = harness.fusion_node()
    harness.spin_until(lambda: held.threads, "a check")
    harness.remove(node)
    held.go_on.set()
    held.threads[0].join(TIMEOUT)
    assert not held.threads[0].is_alive()


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
