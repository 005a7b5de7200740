# SPDX-License-Identifier: Apache-2.0
"""Samples that may not reach the method: dropped, counted, named; and fusing goes on."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import pytest
from nodes.watching import WARN, Diagnostics

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.testing import Harness
from fuzzy_fusion_ros.testing.feed import START_NS

STEP_NS = 10_000_000
CLEAN = [Sample(START_NS + k * STEP_NS, math.sin(0.3 * k)) for k in range(20)]

Spoilt = Callable[[Sample], Sample]
"""Makes a bad sample out of the last good one."""

NEVER_USABLE: dict[str, tuple[Spoilt, Drop]] = {
    "NaN": (lambda last: Sample(last.stamp_ns + 1, math.nan), Drop.NOT_FINITE),
    "+inf": (lambda last: Sample(last.stamp_ns + 1, math.inf), Drop.NOT_FINITE),
    "-inf": (lambda last: Sample(last.stamp_ns + 1, -math.inf), Drop.NOT_FINITE),
    "zero stamp": (lambda last: Sample(0, last.value), Drop.ZERO_STAMP),
    "far future": (lambda last: Sample(time.time_ns() + 3600 * 10**9, 0.0), Drop.FUTURE_STAMP),
}
OUT_OF_ORDER: dict[str, tuple[Spoilt, Drop]] = {
    "duplicate": (lambda last: last, Drop.NOT_NEWER),
    "same stamp, other value": (lambda last: Sample(last.stamp_ns, 9.0), Drop.NOT_NEWER),
    "late": (lambda last: Sample(last.stamp_ns - 3 * STEP_NS, 9.0), Drop.NOT_NEWER),
}

COUNTS = {
    Drop.NOT_FINITE.value: "6",
    Drop.ZERO_STAMP.value: "2",
    Drop.FUTURE_STAMP.value: "2",
    Drop.NOT_NEWER.value: "3",
    Drop.UNPAIRED.value: "0",
}


def fused_by_the_core() -> list[float]:
    """What comes out of the good samples alone."""
    fusion = Fusion(Parameters())
    out = []
    for sample in CLEAN:
        fusion.on_s2(sample)
        (fused,) = fusion.on_s1(sample).estimates
        out.append(fused.estimate.value)
    return out


@pytest.mark.parametrize("sensor", ["s1", "s2"])
def test_bad_samples_change_nothing_but_counts(
    harness: Harness, diagnostics: Diagnostics, sensor: str
) -> None:
    # The executor may take a good sample of S1 together with a bad one before it, before S2's.
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    publisher = getattr(feed, sensor)
    for spoil, _ in NEVER_USABLE.values():
        feed.publish(publisher, spoil(CLEAN[0]))  # the very first messages
    got = []
    for k, sample in enumerate(CLEAN):
        if k == 10:
            for spoil, _ in (*NEVER_USABLE.values(), *OUT_OF_ORDER.values()):
                feed.publish(publisher, spoil(CLEAN[k - 1]))
        at = (sample.stamp_ns - START_NS) * 1e-9
        got.append(feed(at, s1=sample.value, s2=sample.value))
    assert got == fused_by_the_core()
    assert len(feed.estimates) == len(CLEAN)
    assert diagnostics.saying(f"fusion_node: {sensor}", Drop.NOT_NEWER.value).level == WARN
    status = diagnostics.having(f"fusion_node: {sensor}", "admitted", str(len(CLEAN)))
    assert {name: status.values[f"dropped: {name}"] for name in COUNTS} == COUNTS
    assert status.values["last reason for a drop"] == Drop.NOT_NEWER.value
    other = "s2" if sensor == "s1" else "s1"
    dropped = diagnostics.of(f"fusion_node: {other}")[-1].values
    assert {dropped[f"dropped: {each.value}"] for each in Drop} == {"0"}


def test_huge_samples_give_finite_estimates(harness: Harness) -> None:
    harness.fusion_node({"predictor.enabled": True})
    feed = harness.feed()
    largest = 1.7e308
    for k in range(60):
        sign = (-1) ** k
        assert math.isfinite(feed(0.01 * k, s1=sign * largest, s2=-sign * largest))
