# SPDX-License-Identifier: Apache-2.0
"""Each fault over DDS: the node gives the core's estimates, and counts what was injected."""

from __future__ import annotations

import functools
import random
from collections import Counter

import pytest
from nodes.watching import Diagnostics

from faults.fusing import run
from faults.injector import FAULTS, shifted
from faults.streams import S1, S2, SECOND_NS, Stream, clean_stream
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.nodes.sensor_input import SensorInput
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.testing import Harness

FAR_APART_NS = 10_000 * SECOND_NS


def has_received(source: SensorInput, messages: int) -> bool:
    """Return whether so many messages have come in."""
    return source.subscription.received >= messages


@pytest.mark.parametrize("sensor", [S1, S2])
def test_one_fault_after_the_other(harness: Harness, diagnostics: Diagnostics, sensor: str) -> None:
    """All of them in one run; each sample is sent when the one before has been taken."""
    stream: Stream = []
    drops: Counter[Drop] = Counter()
    for k, (name, fault) in enumerate(FAULTS.items()):
        sound = shifted(clean_stream(60), k * FAR_APART_NS)
        spoilt = fault(sound, sensor, 20, 8, random.Random(name))
        stream += spoilt.stream
        drops += spoilt.drops
    expected = run(Parameters(), stream)
    assert expected.dropped[sensor] == drops

    node = harness.fusion_node()
    feed = harness.feed()
    inputs = {S1: node.channels[0].s1, S2: node.channels[0].s2}
    publishers = {S1: feed.s1, S2: feed.s2}
    for each in stream:
        taken = inputs[each.sensor].subscription.received
        feed.publish(publishers[each.sensor], each.sample)
        has_come = functools.partial(has_received, inputs[each.sensor], taken + 1)
        harness.spin_until(has_come, "a sample taken")
    wanted = [Sample(each.stamp_ns, each.estimate.value) for each in expected.estimates]
    harness.spin_until(lambda: len(feed.estimates) >= len(wanted), "the last estimate")
    assert feed.estimates == wanted

    said = diagnostics.next(f"fusion_node: {sensor}").values
    assert {each: int(said[f"dropped: {each.value}"]) for each in Drop} == {
        each: drops[each] for each in Drop
    }
    assert int(said["received"]) == sum(each.sensor == sensor for each in stream)
    other = diagnostics.next(f"fusion_node: {S2 if sensor == S1 else S1}").values
    assert {other[f"dropped: {each.value}"] for each in Drop} == {"0"}
    fusion = diagnostics.next("fusion_node: fusion").values
    assert fusion["restarts after timestamps jumped back"] == str(expected.restarts)
