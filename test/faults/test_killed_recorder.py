# SPDX-License-Identifier: Apache-2.0
"""SIGKILL at random moments of a recording."""

from __future__ import annotations

from pathlib import Path

from faults.killing import expected_s1, kill
from fuzzy_fusion_ros.testing import Harness


def test_what_was_whole_on_disk_is_read_and_replayed(tmp_path: Path) -> None:
    whole = expected_s1()
    with Harness() as harness:
        left = [kill(harness, tmp_path / "run", seed, whole) for seed in range(3)]
    assert any(each.chunks > 0 for each in left)
