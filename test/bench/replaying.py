# SPDX-License-Identifier: Apache-2.0
"""Offline replay against rosbags' own loop that reads and decodes."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rosbags.highlevel import AnyReader

from bench.big_bag import JOINTS, RECORDING, SENSORS, write_bag
from bench.effort import Effort
from bench.estimator import COMPLETE, FA
from bench.measuring import compared, cpu_seconds, interleaved
from bench.table import Row, at_least
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters

BAGS = {
    "pendulum's five topics": RECORDING,
    "s1 and s2 alone": SENSORS,
}


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, topics in BAGS.items():
            found += _rows(Path(folder), name, topics, effort)
    return found


def _rows(folder: Path, name: str, topics: Sequence[tuple[str, str]], effort: Effort) -> list[Row]:
    n = effort.messages
    path = folder / "bag"
    write_bag(path, n, topics)
    reading, fusing, fa, complete, theirs = interleaved(
        effort.repetitions,
        lambda: n / cpu_seconds(lambda: read(path)),
        lambda: n / cpu_seconds(lambda: fuse(path)),
        lambda: n / _replay(path, folder / "out", FA),
        lambda: n / _replay(path, folder / "out", COMPLETE),
        lambda: n / cpu_seconds(lambda: rosbags_loop(path)),
    )
    shutil.rmtree(path)
    what = f"{n:,} messages, {name}"
    found = []
    for rates, part in (
        (reading, "read all, stamp and one number"),
        (fusing, "read s1 and s2, fuse (FA), write nothing"),
        (fa, "replay (FA), write estimate and explanation"),
        (complete, "replay (complete), write estimate and explanation"),
    ):
        it = compared(rates, theirs)
        aim = at_least(1.0) if part.startswith("replay") else None
        against = f"{it.against / 1e3:.0f}k/s rosbags, read and decode all"
        found.append(
            Row(f"{part}: {what}", f"{it.ours / 1e3:.0f}k/s of CPU", against, it.ratio, aim)
        )
    return found


def _replay(path: Path, output: Path, parameters: Parameters) -> float:
    """Return seconds of CPU time."""

    def work() -> None:
        with open_bag(path) as bag:
            replay(bag, output, Topics(), parameters)

    taken = cpu_seconds(work)
    shutil.rmtree(output)
    return taken


def rosbags_loop(path: Path) -> None:
    """Read and decode every message as rosbags' documentation does."""
    with AnyReader([path]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)


def read(path: Path) -> None:
    """Read the stamp and one number of every message with this package."""
    fields = {POINT: "point.x", JOINTS: "position[0]"}
    with open_bag(path) as bag:
        codecs = {name: ScalarCodec(bag.types, name, field) for name, field in fields.items()}
        for message in bag.messages():
            codecs[message.msgtype].sample(message.data, message.log_ns)


def fuse(path: Path) -> None:
    """Run the fusion over a bag and keep nothing."""
    fusion = Fusion(FA)
    take = {"/s1": fusion.on_s1, "/s2": fusion.on_s2}
    with open_bag(path) as bag:
        codec = ScalarCodec(bag.types, POINT)
        for message in bag.messages():
            if message.topic in take:
                sample = codec.sample(message.data, message.log_ns)
                take[message.topic](sample, message.log_ns)
