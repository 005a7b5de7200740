"""Messages are held while the executor is behind, and the newest comes out."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.nodes import backlog as module
from fuzzy_fusion_ros.nodes.backlog import EVERY, Backlog
from fuzzy_fusion_ros.testing import Harness


def test_all_pass_while_the_answer_is_not_late(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LATE", 1e3)
    passed: list[bytes] = []
    backlog = Backlog(harness.fusion_node(), passed.append)
    sent = [b"%d" % k for k in range(5 * EVERY)]
    for data in sent:
        backlog.take(data)
    assert passed == sent
    assert backlog.shed == 0


def test_the_newest_comes_out_once_it_has_caught_up(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "LATE", 0.0)
    passed: list[bytes] = []
    backlog = Backlog(harness.fusion_node(), passed.append)
    first = [b"%d" % k for k in range(EVERY)]
    for data in [*first, b"older", b"old", b"newest"]:
        backlog.take(data)
    assert passed == first
    assert backlog.shed == 2
    harness.spin_until(lambda: passed[-1] == b"newest", "the newest")
    backlog.take(b"next")
    assert passed == [*first, b"newest", b"next"]
    assert backlog.shed == 2
