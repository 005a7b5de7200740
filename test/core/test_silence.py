# SPDX-License-Identifier: Apache-2.0
"""The interval of a sensor, followed, and the automatic timeout."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.core.estimator import FUSED
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, S2_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 10**9


def test_the_interval_is_a_running_mean_that_gaps_hardly_move() -> None:
    assert followed(0.0, 0.5) == 0.5
    assert followed(1.0, 2.0) == pytest.approx(1.1)
    assert followed(1.0, 1e6) == pytest.approx(1.2)
    assert followed(1.0, -5.0) == pytest.approx(0.9)


@pytest.mark.parametrize(
    ("configured", "interval", "timeout"),
    [(0.0, 0.0, S1_TIMEOUT), (0.0, 0.01, S1_TIMEOUT), (0.0, 6.0, 30.0), (0.3, 6.0, 0.3)],
)
def test_what_is_configured_comes_before_what_is_seen(
    configured: float, interval: float, timeout: float
) -> None:
    assert timeout_for(configured, S1_TIMEOUT, interval) == timeout


@pytest.mark.parametrize("trigger", ["s1", "timer"])
def test_slow_sensors_are_fused_without_a_timeout_to_set(trigger: str) -> None:
    """S1 once a second, S2 every six: by fixed defaults S2 would be lost before each sample."""
    fusion = Fusion(replace(Parameters(), {"trigger": trigger}))
    modes = []
    for k in range(1, 121):
        stamp_ns = k * SECOND
        if k % 6 == 1:
            modes += fusion.on_s2(Sample(stamp_ns, 1.0)).estimates
        modes += fusion.on_s1(Sample(stamp_ns, 1.0)).estimates
        modes += fusion.on_tick().estimates
    assert {fused.estimate.mode for fused in modes if fused.stamp_ns > 7 * SECOND} == {FUSED}
    assert len(modes) == 120


def test_pairs_of_slow_sensors_wait_for_each_other() -> None:
    fusion = Fusion(replace(Parameters(), {"trigger": "pair"}))
    said = []
    for k in range(1, 40):
        said += fusion.on_s1(Sample(k * 3 * SECOND, 1.0)).estimates
        if k > 1:
            said += fusion.on_s2(Sample((k - 1) * 3 * SECOND, 1.0)).estimates
    late = [fused for fused in said if fused.stamp_ns > 20 * SECOND]
    assert {fused.estimate.mode for fused in late} == {FUSED}
    assert len(late) >= 30


def test_fast_sensors_have_the_shortest_timeouts() -> None:
    fusion = Fusion(Parameters())
    for k in range(1, 200):
        fusion.on_s2(Sample(SECOND + k * 10_000_000, 1.0))
        fusion.on_s1(Sample(SECOND + k * 10_000_000, 1.0))
    assert fusion.s1.timeout(0.0) == S1_TIMEOUT
    assert fusion.s2.timeout(0.0) == S2_TIMEOUT
