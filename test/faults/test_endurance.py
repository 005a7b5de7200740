# SPDX-License-Identifier: Apache-2.0
"""The soak in its short form: minutes become seconds, what is checked stays."""

from __future__ import annotations

import pytest

from faults.endurance import run_over_dds, step


@pytest.mark.slow("what the node does, without DDS")
def test_the_core_holds_no_more_after_many_samples() -> None:
    stepped = step(20_000, seed=1)
    assert stepped.estimates > 15_000
    assert stepped.late_growth < 8.0
    assert stepped.more_descriptors == 0


def test_the_node_holds_no_more_and_stays_right() -> None:
    ran = run_over_dds(4.0, 500.0, seed=1)
    assert ran.estimates > 1_000
    assert ran.late_growth < 8.0
    assert ran.more_descriptors == 0
