# SPDX-License-Identifier: Apache-2.0
"""Processes that are killed and restarted under the eyes of those that stay."""

from __future__ import annotations

import random
import signal
from typing import Any

from nodes.watching import Log

from faults.waiting import after, as_arguments, at_least, said_again
from fuzzy_fusion_ros.nodes.pendulum_node import PendulumNode
from fuzzy_fusion_ros.testing import Harness

PATIENT = {"s1.timeout": 0.3, "s2.timeout": 0.3}


def kill_the_sensors(harness: Harness, times: int, seed: int) -> int:
    """Kill and restart the process of both sensors; return how many estimates there were in all.

    The fusion runs on; each time it must give estimates of the new process by itself.

    Args:
        harness: The graph to run in.
        times: How often.
        seed: Of the moments.

    Raises:
        TimeoutError: It does not.
    """
    rng = random.Random(seed)
    harness.fusion_node(PATIENT)
    log = Log(harness)
    estimates = harness.record("/estimate")
    settings = as_arguments({"feedback": "truth", "real_time_factor": 1.0, "duration": 1e4})
    for k in range(times + 1):
        fused = said_again(log.count, "FUSED: ")
        sensors = harness.start("pendulum_node", *settings)
        harness.spin_until(fused, f"both sensors fused after {k} kills")
        wanted = len(estimates) + rng.randrange(1, 100)
        harness.spin_until(at_least(wanted, estimates), f"estimates after {k} kills")
        stale = said_again(log.count, "STALE: ")
        sensors.send(signal.SIGKILL)
        sensors.wait()
        harness.spin_until(stale, "both sensors told lost")
    stamps = [each.header.stamp.sec * 10**9 + each.header.stamp.nanosec for each in estimates]
    assert stamps == sorted(set(stamps))
    return len(stamps)


def kill_the_fusion(harness: Harness, times: int, seed: int) -> int:
    """Kill and restart fusion_node under a paced pendulum that stands on its estimates.

    Its pole is long and its time slow, so that it takes minutes to fall: longer than a process
    takes to start even on a busy machine.

    Args:
        harness: The graph to run in.
        times: How often.
        seed: Of the moments.

    Returns:
        Estimates in all.

    Raises:
        TimeoutError: A new process is not taken up, or the pendulum gave up or fell.
    """
    rng = random.Random(seed)
    fusion = harness.start("fusion_node")
    plant: dict[str, Any] = {
        "real_time_factor": 0.03,
        "duration": 1e4,
        "timeout": 60.0,
        "plant.half_length": 20.0,
    }
    pendulum = harness.add(PendulumNode, plant)
    estimates = harness.record("/estimate")
    for k in range(times + 1):
        wanted = len(estimates) + rng.randrange(2, 6)
        harness.spin_until(at_least(wanted, estimates), f"estimates after {k} kills")
        assert not pendulum.finished
        if k < times:
            harness.spin_until(after(rng.uniform(0.0, 0.1)))
            fusion.send(signal.SIGKILL)
            fusion.wait()
            fusion = harness.start("fusion_node")
    return len(estimates)
