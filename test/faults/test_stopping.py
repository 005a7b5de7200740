# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at random moments: status 0, no traceback, a whole bag."""

from __future__ import annotations

from pathlib import Path

import pytest

from faults.stopping import EXECUTABLES, stop_at_random

SLOW = pytest.mark.slow("as the fusion_node")


@pytest.mark.parametrize(
    "name",
    [pytest.param(each, marks=SLOW if each != "fusion_node" else ()) for each in EXECUTABLES],
)
def test_stopped_at_a_random_moment(tmp_path: Path, name: str) -> None:
    ended = stop_at_random(EXECUTABLES[name], tmp_path, 3, seed=1, longest=1.0)
    assert [each.status for each in ended] == [0] * 6
