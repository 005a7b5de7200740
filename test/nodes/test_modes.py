# SPDX-License-Identifier: Apache-2.0
"""Silent sensors: named modes, the other sensor alone, and back by itself."""

from __future__ import annotations

import pytest
from nodes.watching import ERROR, OK, WARN, Diagnostics, Log

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.testing import Harness

SHORT = {"s1.timeout": 0.1, "s2.timeout": 0.3}
TIMES = (0.0, 0.05, 0.09, 0.11, 0.29, 0.31, 0.35)


def test_s2_silent_past_its_timeout_leaves_s1_alone_and_it_comes_back(
    harness: Harness, log: Log
) -> None:
    harness.fusion_node(SHORT)
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=2.0)
    held = feed(0.29, s1=1.0)
    assert held != 1.0  # S2 still counts
    assert feed(0.31, s1=1.25) == 1.25
    assert feed(0.4, s1=1.5) == 1.5
    assert feed(0.41, s1=1.0, s2=2.0) != 1.0
    log.wait_for("S1_ONLY: s2 timed out, using s1 alone")
    harness.spin_until(lambda: log.count("FUSED: both sensors") == 2)
    assert log.count("S1_ONLY") == 1  # on change only


def test_s1_silent_past_its_timeout_leaves_s2_alone_and_it_comes_back(
    harness: Harness, log: Log
) -> None:
    harness.fusion_node(SHORT)
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=2.0)
    feed.send(0.1, s2=2.25)  # not lost yet: no estimate
    late = (0.11, 0.2, 0.3)
    lone = [feed.send(at, s2=2.0 + at) for at in late]
    harness.spin_until(lambda: len(feed.estimates) == 4)
    expected = [Sample(stamp, 2.0 + at) for stamp, at in zip(lone, late, strict=True)]
    assert feed.estimates[1:] == expected
    assert 1.0 <= feed(0.31, s1=1.0) <= 2.3
    log.wait_for("S2_ONLY: s1 timed out, using s2 alone")
    harness.spin_until(lambda: log.count("FUSED: both sensors") == 2)
    assert log.count("S2_ONLY") == 1


@pytest.mark.parametrize("sensor", ["s1", "s2"])
def test_a_sensor_that_never_speaks_is_not_waited_for_longer_than_its_timeout(
    harness: Harness, sensor: str
) -> None:
    harness.fusion_node(SHORT)
    feed = harness.feed()
    for at in TIMES:
        feed.send(at, **{"s2" if sensor == "s1" else "s1": at})
    harness.spin_until(lambda: feed.estimates and feed.estimates[-1].value == 0.35)
    timeout = SHORT[f"{sensor}.timeout"]
    assert [sample.value for sample in feed.estimates] == [at for at in TIMES if at > timeout]


def test_both_silent_is_stale_and_an_error_and_ends_by_itself(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node(SHORT)
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    stale = diagnostics.saying("fusion_node: fusion", "STALE")
    assert stale.level == ERROR
    assert stale.values["mode"] == "STALE"
    log.wait_for("STALE: no sample of either sensor within its timeout, nothing is published")
    assert diagnostics.next("fusion_node: s1").level == WARN
    assert "silent for" in diagnostics.next("fusion_node: s2").message
    assert len(feed.estimates) == 1
    assert feed(10.0, s1=1.0, s2=1.0) == 1.0  # S2 comes first, and S1 counts as lost for that once
    assert feed(10.01, s1=1.0, s2=1.0) == 1.0
    harness.spin_until(lambda: log.count("FUSED: both sensors") == 2)
    assert log.count("STALE") == 1


def test_diagnostics_name_the_mode_of_a_lost_sensor(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({**SHORT, "s1.timeout": 1000.0})
    feed = harness.feed()
    feed(0.0, s1=1.0, s2=1.0)
    fused = diagnostics.saying("fusion_node: fusion", "FUSED")
    assert (fused.level, fused.values["mode"]) == (OK, "FUSED")
    feed(1.0, s1=1.0)
    lone = diagnostics.saying("fusion_node: fusion", "S1_ONLY")
    assert (lone.level, lone.values["mode"]) == (WARN, "S1_ONLY")


def test_before_the_first_message_the_node_waits_however_long(
    harness: Harness, log: Log, diagnostics: Diagnostics
) -> None:
    harness.fusion_node(SHORT)
    assert diagnostics.saying("fusion_node: s1", "silent for").level == WARN
    assert diagnostics.saying("fusion_node: s2", "silent for").level == WARN
    for _ in range(2):
        fusion = diagnostics.next("fusion_node: fusion")
        assert (fusion.level, fusion.values["mode"]) == (OK, "WAITING")
    assert log.count("STALE") == 0


def test_a_sensor_that_has_sent_only_garbage_is_stale(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node(SHORT)
    feed = harness.feed()
    feed.publish(feed.s1, Sample(0, 1.0))
    assert diagnostics.saying("fusion_node: fusion", "STALE").level == ERROR
