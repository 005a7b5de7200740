# SPDX-License-Identifier: Apache-2.0
"""Recorders that are killed: SIGKILL at random moments, and what the bag holds then."""

from __future__ import annotations

import random
import shutil
import signal
from pathlib import Path
from typing import NamedTuple

from bag.making import chunk_ends, decoded, salvage_by_mcap

from faults.waiting import as_arguments, wait_until
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.nodes.parameters import PendulumParameters
from fuzzy_fusion_ros.nodes.stepped_run import SteppedRun
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.testing import Harness

SEED = 3
LARGEST = 400_000
"""Bytes by which a recorder is killed at the latest; the bag of a whole run is larger."""

PLANT = {"feedback": "truth", "duration": 50.0, "seed": SEED}


class Killed(NamedTuple):
    """What was left.

    Attributes:
        bytes: Size of the file.
        chunks: Whole chunks in it.
        messages: Messages that were read.
        estimates: Estimates that its replay made.
    """

    bytes: int
    chunks: int
    messages: int
    estimates: int


def expected_s1() -> list[float]:
    """Return S1 of the whole run."""
    run, found = SteppedRun(replace(PendulumParameters(), PLANT)), []
    while (reading := run.sense()) is not None:
        found.append(reading.s1)
        run.act(run.plant.angle)
    return found


def kill(harness: Harness, folder: Path, seed: int, whole: list[float]) -> Killed:
    """Kill a recording pendulum at a random size of its bag; check what is left of it.

    Args:
        harness: The graph to run in.
        folder: For the bag, emptied before.
        seed: Of the moment.
        whole: S1 of the run, had it not been killed.

    Raises:
        AssertionError: What was whole on disk is not read, or something else is.
    """
    shutil.rmtree(folder, ignore_errors=True)
    path, size = folder / "bag", random.Random(seed).randrange(1, LARGEST)
    process = harness.start("pendulum_node", *as_arguments({**PLANT, "record": path}))
    file = path / "bag_0.mcap"
    wait_until(
        lambda: process.status is not None or (file.exists() and file.stat().st_size >= size),
        f"{file} has {size} bytes",
    )
    process.send(signal.SIGKILL)
    assert process.wait() == -signal.SIGKILL, process.stderr
    data = file.read_bytes()
    with open_bag(path) as bag:
        messages = list(bag.messages())
        found = [decoded(each).point.x for each in messages if each.topic == "/s1"]
        assert {each.data for each in messages} >= set(salvage_by_mcap(data))
        assert found == whole[: len(found)]
        assert (len(messages) > 0) == (len(chunk_ends(data)) > 0)
        if not messages:
            return Killed(len(data), 0, 0, 0)
        done = replay(bag, folder / "replayed", Topics(), Parameters())
    assert done.estimates == len(found)
    return Killed(len(data), len(chunk_ends(data)), len(messages), done.estimates)
