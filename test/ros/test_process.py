# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at any moment: exit 0, the bag closed and readable.

A few moments drawn at random; test/soak.py draws many.
"""

from __future__ import annotations

import random
import signal
import time
from pathlib import Path

import pytest

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.testing import Harness, Process

MOMENTS = pytest.mark.parametrize(
    "moment", [0, *(pytest.param(k, marks=pytest.mark.slow("more moments")) for k in (1, 2))]
)
SIGNALS = pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda n: n.name)


def takes_signals(process: Process) -> bool:
    """Whether the process has come as far as its main function."""
    try:
        status = Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return True
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt"))
    return bool(int(caught.split()[1], 16) & 1 << (signal.SIGTERM - 1))


def send_at_random(
    harness: Harness, process: Process, number: int, generator: random.Random
) -> None:
    """Send a signal at some moment of start-up or spinning."""
    harness.spin_until(lambda: takes_signals(process))
    moment = time.monotonic() + generator.uniform(0.0, 0.8)
    harness.spin_until(lambda: time.monotonic() >= moment)
    process.send(signal.Signals(number))


@MOMENTS
@SIGNALS
@pytest.mark.parametrize("executable", ["fusion_node", "sensor_subscriber", "pendulum_node"])
def test_a_signal_at_any_moment_ends_a_node_in_good_order(
    harness: Harness, executable: str, number: int, moment: int
) -> None:
    process = harness.start(executable)
    send_at_random(harness, process, number, random.Random(f"{executable} {number} {moment}"))
    assert process.wait() == 0, process.stderr
    assert "Traceback" not in process.stderr


@MOMENTS
@SIGNALS
def test_a_recording_is_whole_after_a_signal(
    harness: Harness, tmp_path: Path, number: int, moment: int
) -> None:
    bag = tmp_path / "bag"
    harness.fusion_node()
    process = harness.start("pendulum_node", "--ros-args", "-p", f"record:={bag}")
    seen = harness.record("/truth")
    harness.spin_until(lambda: len(seen) > 10, "a run under way")
    send_at_random(harness, process, number, random.Random(f"{number} {moment}"))
    assert process.wait() == 0, process.stderr
    with open_bag(bag) as reader:
        assert reader.problems == []
        counts = {name: topic.message_count for name, topic in reader.topics.items()}
    assert counts["/truth"] == counts["/s1"] == counts["/s2"]
    assert (counts["/truth"] or 0) > 10


def test_a_signal_is_heeded_while_waiting_for_peers(harness: Harness, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    process = harness.start("pendulum_node", "--ros-args", "-p", f"record:={bag}")
    harness.spin_until(lambda: harness.node.count_publishers("/truth"))
    process.send(signal.SIGTERM)
    assert process.wait() == 0, process.stderr
    with open_bag(bag) as reader:
        assert list(reader.messages()) == []
