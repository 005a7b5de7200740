# SPDX-License-Identifier: Apache-2.0
"""Each fault in a bag: its replay gives the core's estimates and names what it left out."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from bag.making import POINT, decoded, point_data

from faults.fusing import run
from faults.injector import FAULTS
from faults.streams import S1, S2, Stream, clean_stream
from fuzzy_fusion_ros.bag import BagMessage, BagWriter, open_bag
from fuzzy_fusion_ros.offline.replay import Replayed, replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters


def write(path: Path, stream: Stream) -> None:
    """Record a stream."""
    with BagWriter(path) as writer:
        for sensor, sample, now_ns in stream:
            data = point_data(sample.stamp_ns, sample.value)
            writer.write(*BagMessage(f"/{sensor}", POINT, now_ns, data))


def replayed(source: Path, output: Path) -> tuple[Replayed, list[tuple[int, float]]]:
    """Replay a bag; return what was done, and the estimates by their stamps."""
    with open_bag(source) as bag:
        done = replay(bag, output, Topics(), Parameters())
    with open_bag(output) as bag:
        found = [decoded(each) for each in bag.messages(["/estimate"])]
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in found]
    return done, [(ns, each.point.x) for ns, each in zip(stamps, found, strict=True)]


@pytest.mark.parametrize("sensor", [S1, S2])
@pytest.mark.parametrize("fault", FAULTS)
def test_a_replay_survives_it_and_names_it(tmp_path: Path, fault: str, sensor: str) -> None:
    rng = random.Random(f"{fault} {sensor}")
    spoilt = FAULTS[fault](clean_stream(150), sensor, 30, 12, rng)
    write(tmp_path / "bag", spoilt.stream)
    done, estimates = replayed(tmp_path / "bag", tmp_path / "out")
    expected = run(Parameters(), spoilt.stream).estimates
    assert estimates == [(each.stamp_ns, each.estimate.value) for each in expected]
    assert sorted(done.notes) == sorted(
        f"/{sensor}: {n} dropped: {reason.value}" for reason, n in spoilt.drops.items()
    )
    assert done.restarts == spoilt.restarts
    assert done.messages == len(spoilt.stream)
