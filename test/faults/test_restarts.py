# SPDX-License-Identifier: Apache-2.0
"""Processes killed at random and started again: the others go on by themselves."""

from __future__ import annotations

import pytest

from faults.restarting import kill_the_fusion, kill_the_sensors
from fuzzy_fusion_ros.testing import Harness


@pytest.mark.slow("as with the fusion, to others")
def test_sensors_killed_and_restarted() -> None:
    with Harness() as harness:
        assert kill_the_sensors(harness, 2, seed=1) > 0


def test_fusion_killed_and_restarted_under_a_pendulum() -> None:
    with Harness() as harness:
        assert kill_the_fusion(harness, 2, seed=1) > 0
