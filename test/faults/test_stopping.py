# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at random moments: status 0, no traceback, a whole bag."""

from __future__ import annotations

from pathlib import Path

import pytest

from faults.stopping import EXECUTABLES, stop_at_random

SLOW = pytest.mark.slow("as the fusion_node, and more moments")


@pytest.mark.parametrize(
    ("name", "rounds"),
    [("fusion_node", 2), *(pytest.param(each, 3, marks=SLOW) for each in EXECUTABLES)],
)
def test_stopped_at_a_random_moment(tmp_path: Path, name: str, rounds: int) -> None:
    ended = stop_at_random(EXECUTABLES[name], tmp_path, rounds, seed=1, longest=1.0)
    assert [each.status for each in ended] == 2 * rounds * [0]
