# SPDX-License-Identifier: Apache-2.0
"""When the timer trigger's ticks are due on a bag's clock."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

MS = 1_000_000


def test_the_first_tick_due_of_a_period_of_the_rate() -> None:
    ticks = Ticks(replace(Parameters(), {"trigger": "timer", "rate": 50.0}))
    due = [ticks.due(at * MS) for at in (5, 24, 25, 26, 100, 104, 105)]
    assert due == [None, None, 25 * MS, None, 45 * MS, None, 105 * MS]


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_no_tick_for_other_triggers(trigger: str) -> None:
    ticks = Ticks(replace(Parameters(), {"trigger": trigger, "rate": 50.0}))
    assert [ticks.due(at * MS) for at in (0, 20, 1000)] == [None] * 3
