# SPDX-License-Identifier: Apache-2.0
"""The share of time in each mode."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY
from fuzzy_fusion_ros.online.mode_shares import ModeShares, in_words

SECOND = 10**9


@pytest.mark.parametrize(
    ("seen", "said"),
    [
        ([], "no estimate"),
        ([(S1_ONLY, 1)], "S1_ONLY 100 % of the time"),
        ([(S1_ONLY, 1), (FUSED, 2), (FUSED, 3)], "FUSED 100 % of the time"),
        ([(FUSED, 1), (S1_ONLY, 2), (FUSED, 5)], "FUSED 75 % of the time, S1_ONLY 25 %"),
        ([(FUSED, 1), (S1_ONLY, 6), (FUSED, 1000)], "FUSED 66.7 % of the time, S1_ONLY 33.3 %"),
    ],
)
def test_time_is_that_of_the_later_estimate(seen: list[tuple[int, int]], said: str) -> None:
    shares = ModeShares()
    for mode, seconds in seen:
        shares.see(mode, seconds * SECOND)
    assert in_words(shares.shares()) == said
