# SPDX-License-Identifier: Apache-2.0
"""Offline replay against rosbags' own loop that reads and decodes."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from rosbags.highlevel import AnyReader

from bench.big_bag import JOINTS, RECORDING, SENSORS, Topics, write_bag
from bench.effort import Effort
from bench.estimator import COMPLETE, FA
from bench.measuring import compared, cpu_seconds, interleaved
from bench.table import Aim, Row, at_most
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.batch.series import fusion, run
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.offline import topics as bag_topics
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.parameters.fusion import Parameters

BAGS = {
    "pendulum's five topics": RECORDING,
    "s1 at 100 Hz, s2 at 10 Hz": SENSORS,
}


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for name, topics in BAGS.items():
            found += _rows(Path(folder), name, topics, effort)
    return found


def _rows(folder: Path, name: str, topics: Topics, effort: Effort) -> list[Row]:
    n = effort.messages
    path, output = folder / "bag", folder / "out"
    write_bag(path, n, topics)
    run(fusion(FA), read_arrays(path).series)  # compiled once per machine, not per replay
    parts: dict[str, tuple[Callable[[], float], Aim | None]] = {
        "read for score and tune": (lambda: cpu_seconds(lambda: read_arrays(path)), None),
        "read all, stamp and one number, one by one": (
            lambda: cpu_seconds(lambda: read(path)),
            None,
        ),
        "replay (FA), estimate alone": (
            lambda: replayed(path, output, FA, explained=False),
            at_most(0.2),
        ),
        "replay (FA), estimate and explanation": (
            lambda: replayed(path, output, FA),
            at_most(0.5),
        ),
        "replay (complete), estimate and explanation": (
            lambda: replayed(path, output, COMPLETE),
            at_most(1.0),
        ),
    }
    work = [lambda each=each: 1e6 * each() / n for each, _ in parts.values()]
    *ours, theirs = interleaved(
        effort.repetitions, *work, lambda: 1e6 * cpu_seconds(lambda: rosbags_loop(path)) / n
    )
    shutil.rmtree(path)
    found = []
    for taken, (part, (_, aim)) in zip(ours, parts.items(), strict=True):
        it = compared(taken, theirs)
        against = f"{it.against:.1f} µs rosbags, read and decode all"
        what = f"{part}, CPU per message: {n:,} messages, {name}"
        found.append(Row(what, f"{it.ours:.2f} µs", against, it.ratio, aim))
    return found


def replayed(path: Path, output: Path, parameters: Parameters, *, explained: bool = True) -> float:
    """Replay a bag; return seconds of CPU time."""

    def work() -> None:
        with open_bag(path) as bag:
            replay(bag, output, bag_topics.Topics(), parameters, explained=explained)

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


def read_arrays(path: Path) -> Recording:
    """Read a bag as score and tune do."""
    with open_bag(path) as bag:
        return read_recording(bag, bag_topics.Topics(), Parameters())
