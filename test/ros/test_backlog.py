# SPDX-License-Identifier: Apache-2.0
"""The newest message is held while the executor is late."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.ros import backlog as module
from fuzzy_fusion_ros.ros.backlog import EVERY, Backlog
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.ros.subscription import RawSubscription
from fuzzy_fusion_ros.testing import Harness

FIRST = [b"%d" % k for k in range(EVERY)]
"""Messages up to the first probe."""

INFO = {"publication_sequence_number": None}


@pytest.fixture
def handled() -> list[bytes]:
    """What has been handed on."""
    return []


@pytest.fixture
def receive(harness: Harness, handled: list[bytes]) -> RawSubscription:
    """A subscription in a graph that runs only when a test says so."""
    profile = input_profile("sensor_data")
    return RawSubscription(harness.fusion_node(), "s3", POINT, profile, handled.append)


def test_all_pass_while_the_answer_is_not_late(
    receive: RawSubscription, handled: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LATE", 1e3)
    for data in 5 * FIRST:
        receive(data, INFO)
    assert handled == 5 * FIRST
    assert (receive.received, receive.lost) == (len(handled), 0)


def test_the_newest_comes_out_once_the_executor_has_caught_up(
    harness: Harness,
    receive: RawSubscription,
    handled: list[bytes],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "LATE", 0.0)
    for data in [*FIRST, b"older", b"old", b"newest"]:
        receive(data, INFO)
    assert handled == FIRST
    assert receive.lost == 2
    harness.spin_until(lambda: handled[-1] == b"newest", "the newest")
    receive(b"next", INFO)
    assert handled == [*FIRST, b"newest", b"next"]
    assert receive.lost == 2


def test_without_a_probe_nothing_is_held() -> None:
    backlog = Backlog()
    assert not any(backlog.holds(data) for data in 5 * FIRST)
    assert backlog.answered() is None
