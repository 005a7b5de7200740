"""Offline replay against rosbags' own loop that reads and decodes; and memory over length."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rosbags.highlevel import AnyReader

from bench.big_bag import RECORDING, SENSORS, write_bag
from bench.child import environment, module
from bench.effort import Effort
from bench.estimator import COMPLETE, FA
from bench.measuring import compared, cpu_seconds, interleaved
from bench.table import Row, at_least, at_most
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.bag.replay import replay
from fuzzy_fusion_ros.bag.roles import Topics
from fuzzy_fusion_ros.core.fusion import Fusion
from fuzzy_fusion_ros.core.parameters import Parameters
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.outputs import POINT

LIMIT_MB = 200.0
LONGEST = 10_000_000
"""Messages for which the memory limit is meant."""

ENOUGH = 100_000
"""Messages from which on growth of memory stands out from its noise."""

BAGS = {
    "pendulum's five topics": RECORDING,
    "s1 and s2 alone": SENSORS,
}


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time, then memory."""
    with tempfile.TemporaryDirectory() as folder:
        found = []
        for name, topics in BAGS.items():
            found += _rate_rows(Path(folder), name, topics, effort)
        return found + _memory_rows(Path(folder), effort)


def _rate_rows(
    folder: Path, name: str, topics: Sequence[tuple[str, str]], effort: Effort
) -> list[Row]:
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
        (reading, "read and decode all"),
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
    """Read and decode every message with this package."""
    with open_bag(path) as bag:
        for message in bag.messages():
            bag.decode(message)


def fuse(path: Path) -> None:
    """Run the fusion over a bag and keep nothing."""
    fusion = Fusion(FA)
    take = {"/s1": fusion.take_s1, "/s2": fusion.take_s2}
    with open_bag(path) as bag:
        codec = ScalarCodec(bag.types, POINT)
        for message in bag.messages():
            if message.topic in take:
                sample = codec.sample(message.data, message.log_ns)
                take[message.topic](sample, message.log_ns)


def _memory_rows(folder: Path, effort: Effort) -> list[Row]:
    sizes = [effort.messages // 4, effort.messages // 2, effort.messages]
    peaks = []
    for size in sizes:
        path, output = folder / "bag", folder / "out"
        write_bag(path, size, RECORDING)
        done = subprocess.run(
            module("replay_once", str(path), str(output)),
            env=environment({}),
            capture_output=True,
            text=True,
            check=True,
        )
        peaks.append(int(done.stdout) / 1024.0)
        shutil.rmtree(path)
        shutil.rmtree(output)
    slope = (peaks[-1] - peaks[0]) / (sizes[-1] - sizes[0])
    measured = [
        Row(
            f"replay's peak memory, {size:,} messages",
            f"{peak:.0f} MB",
            "",
            peak,
            at_most(LIMIT_MB, "MB"),
        )
        for size, peak in zip(sizes, peaks, strict=True)
    ]
    if sizes[-1] < ENOUGH:
        return measured
    projected = peaks[-1] + slope * (LONGEST - sizes[-1])
    return [
        *measured,
        Row(
            f"replay's peak memory, carried on to {LONGEST:,} messages",
            f"{projected:.0f} MB",
            f"{slope * 1e6:.1f} MB more per million",
            projected,
            at_most(LIMIT_MB, "MB"),
        ),
    ]
