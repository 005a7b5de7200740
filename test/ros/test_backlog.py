"""Messages are held while the executor is behind, and the newest comes out."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.ros import backlog as module
from fuzzy_fusion_ros.ros.backlog import EVERY, Backlog
from fuzzy_fusion_ros.testing import Harness

FIRST = [b"%d" % k for k in range(EVERY)]
"""Messages after which the executor is asked."""


@pytest.fixture
def passed() -> list[bytes]:
    """What the backlog has passed on."""
    return []


@pytest.fixture
def backlog(harness: Harness, passed: list[bytes]) -> Backlog:
    """A backlog in a graph that runs only when a test says so."""
    return Backlog(harness.fusion_node(), passed.append)


def test_all_pass_while_the_answer_is_not_late(
    backlog: Backlog, passed: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LATE", 1e3)
    for data in 5 * FIRST:
        backlog.take(data)
    assert passed == 5 * FIRST
    assert backlog.shed == 0


def test_the_newest_comes_out_once_it_has_caught_up(
    harness: Harness, backlog: Backlog, passed: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LATE", 0.0)
    for data in [*FIRST, b"older", b"old", b"newest"]:
        backlog.take(data)
    assert passed == FIRST
    assert backlog.shed == 2
    harness.spin_until(lambda: passed[-1] == b"newest", "the newest")
    backlog.take(b"next")
    assert passed == [*FIRST, b"newest", b"next"]
    assert backlog.shed == 2
