# SPDX-License-Identifier: Apache-2.0
"""A heading that wraps, and a gyro's rate, over DDS: the same as in one process, bit for bit."""

from __future__ import annotations

import math
from typing import Any

import pytest

from fuzzy_fusion_ros.core.periodic import nearest
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.testing import Harness

TURN = 2.0 * math.pi
START = 1.0


@pytest.mark.parametrize("kind", ["value", "rate"])
def test_live_is_the_same_as_in_one_process(harness: Harness, kind: str) -> None:
    given: dict[str, Any] = {"signal.period": TURN, "s1.kind": kind}
    harness.fusion_node(given)
    feed = harness.feed()
    fusion = Fusion(replace(Parameters(), given))
    for k in range(60):
        heading = 2.8 + 0.1 * k
        s1 = 1.0 if kind == "rate" else nearest(heading + 0.05, 0.0, TURN)
        s2 = nearest(heading, 0.0, TURN) if k % 5 == 0 else None
        at = START + 0.1 * k
        stamp_ns = round(at * 1e9)
        if s2 is not None:
            fusion.on_s2(Sample(stamp_ns, s2))
        (fused,) = fusion.on_s1(Sample(stamp_ns, s1)).estimates
        assert feed(at, s1=s1, s2=s2) == fused.estimate.value
        assert -0.5 * TURN < fused.estimate.value <= 0.5 * TURN
        assert abs(nearest(fused.estimate.value - heading, 0.0, TURN)) < 0.6
