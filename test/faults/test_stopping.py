"""SIGINT and SIGTERM at random moments: status 0, no traceback, a whole bag."""

from __future__ import annotations

from pathlib import Path

from faults.stopping import stop_at_random


def test_stopped_at_a_random_moment(tmp_path: Path) -> None:
    stopped = stop_at_random(tmp_path, 5, seed=1, longest=1.0)
    assert stopped.statuses == {0: 5}
