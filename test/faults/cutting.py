# SPDX-License-Identifier: Apache-2.0
"""A cable between two hosts that is cut and reconnected."""

from __future__ import annotations

import itertools
import random
from collections.abc import Callable
from pathlib import Path

from faults.hosts import Hosts, Program
from faults.waiting import after, as_arguments, said_again, wait_until
from fuzzy_fusion_ros.bag import open_bag

DOWN = 3.0
"""How long the cable is cut, seconds."""

STEADY = {"feedback": "truth", "real_time_factor": 1.0, "duration": 1e4}


def cut_the_cable(folder: Path, times: int, seed: int) -> tuple[int, float]:
    """Cut the cable between S2 and the fusion; it must fall back on S1, and come back.

    Host ``a`` has the plant and a sensor_subscriber that republishes S2; host ``b`` has S1, of a
    plant of its own, and the fusion. Nothing is restarted.

    Args:
        folder: For the fusion's bag.
        times: How often.
        seed: Of the moments.

    Returns:
        Estimates in all, and the longest gap between two of them, seconds.

    Raises:
        TimeoutError: The node does not fall back, or does not come back.
    """
    rng = random.Random(seed)
    with Hosts() as hosts:
        renamed = ("-r", "s1:=/a/unused", "-r", "s2:=/raw")
        far = [
            hosts.start("a", "pendulum_node", *as_arguments(STEADY), *renamed),
            hosts.start(
                "a", "sensor_subscriber", "--ros-args", "-r", "input:=/raw", "-r", "output:=/s2"
            ),
        ]
        settings = {"s2.timeout": 0.5, "record": folder}
        fusion = hosts.start("b", "fusion_node", *as_arguments(settings))
        near = hosts.start(
            "b", "pendulum_node", *as_arguments(STEADY), "-r", "s2:=/b/unused", "-r", "__ns:=/b",
            "-r", "s1:=/s1",
        )  # fmt: skip
        wait_for(fusion, lambda: fusion.count("FUSED: "), "FUSED at first")
        for k in range(times):
            wait_until(after(rng.uniform(0.0, 0.5)), "the moment of the fault")
            alone = said_again(fusion.count, "S1_ONLY: ")
            hosts.cut()
            mending = after(DOWN)
            wait_for(fusion, alone, f"S1_ONLY after cut {k}")
            wait_until(mending, "the time to mend")
            fused = said_again(fusion.count, "FUSED: ")
            hosts.mend()
            wait_for(fusion, fused, f"FUSED after cut {k}")
        assert [each.status for each in (*far, near, fusion)] == [None] * 4
        assert fusion.stop() == 0
    with open_bag(folder) as bag:
        times_ns = [each.log_ns for each in bag.messages(["/estimate"])]
    return len(times_ns), max(b - a for a, b in itertools.pairwise(times_ns)) * 1e-9


def wait_for(fusion: Program, predicate: Callable[[], object], what: str) -> None:
    """Wait until something is so, while the fusion runs."""
    wait_until(lambda: fusion.status is not None or predicate(), what)
    assert fusion.status is None, fusion.said.read_text()
