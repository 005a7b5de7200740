# SPDX-License-Identifier: Apache-2.0
"""SIGINT and SIGTERM at random moments in the life of an executable."""

from __future__ import annotations

import random
import signal
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

from faults.waiting import after, as_arguments
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.messages import load_message_class
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.testing import Harness, Process

SIGNALS = (signal.SIGINT, signal.SIGTERM)

PERIOD = 0.01
"""Seconds between two samples of each sensor, and between two looks at a process."""


AGAIN = 0.4
"""The latest moment of the second signal, seconds after the first: the end takes about as long."""


class Executable(NamedTuple):
    """What is stopped.

    Attributes:
        name: The executable.
        inputs: The topics that it is fed on.
        output: The topic that shows that it is at work.
        settings: Its parameters.
        records: Whether it records.
    """

    name: str
    inputs: tuple[str, ...]
    output: str
    settings: dict[str, object]
    records: bool


EXECUTABLES = {
    each.name: each
    for each in (
        Executable("fusion_node", ("/s1", "/s2"), "/estimate", {}, True),
        # It waits for nobody, and its run does not end before it is stopped.
        Executable("pendulum_node", (), "/truth", {"feedback": "truth", "duration": 1e4}, True),
        Executable("sensor_subscriber", ("/input",), "/output", {}, False),
    )
}


class Ended(NamedTuple):
    """How one run ended.

    Attributes:
        number: The signal.
        status: The exit status.
        seconds: From the signal to the end.
        messages: How many messages its bag holds; ``None`` if there is no bag.
    """

    number: signal.Signals
    status: int | None
    seconds: float
    messages: int | None


def handles_signals(process: Process) -> bool:
    """Return whether a process has taken over SIGINT and SIGTERM; before, Python itself has them.

    Python handles SIGINT from its own start on, SIGTERM only after the executable has begun.
    """
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)


def stop_at_random(
    executable: Executable, folder: Path, times: int, seed: int, longest: float
) -> list[Ended]:
    """Start an executable again and again, feed it, and stop it at a random moment.

    Of each signal's tries every other one counts the moment from when the signals are taken over,
    which is start-up; the others from the first message that the executable publishes. Each is told
    by SIGINT once more, at a random moment while it ends.

    Args:
        executable: What to stop.
        folder: For the bags.
        times: How often with each signal.
        seed: Of the moments.
        longest: The latest moment, seconds.

    Raises:
        AssertionError: It did not end with status 0 and in silence, or its bag is not whole.
    """
    rng, ended = random.Random(seed), []
    with Harness() as harness:
        harness.node.create_timer(PERIOD, _feeding(harness, executable.inputs))
        heard = harness.record(executable.output)
        for k in range(times * len(SIGNALS)):
            at_work = k // len(SIGNALS) % 2 == 1
            moment, again = rng.uniform(0.0, longest), rng.uniform(0.0, AGAIN)
            path = folder / f"{k}"
            record = {"record": path} if executable.records else {}
            harness.spin_until(lambda: not harness.node.count_publishers(executable.output), "gone")
            heard.clear()
            process = harness.start(
                executable.name, *as_arguments({**executable.settings, **record})
            )
            harness.spin_until(partial(handles_signals, process), "signals taken over")
            if at_work:
                harness.spin_until(lambda: heard, "at work")
            harness.spin_until(after(moment), "the moment")
            ended.append(_stop(harness, process, SIGNALS[k % len(SIGNALS)], again, path))
            said = (k, ended[-1], process.stderr)
            assert process.status == 0, said
            assert "Traceback" not in process.stderr, said
            assert ended[-1].messages or not (at_work and executable.records), said
            process.close()
    return ended


def _feeding(harness: Harness, topics: tuple[str, ...]) -> Callable[[], None]:
    """Return what publishes a sample of now on each topic."""
    publishers = [harness.publisher(topic) for topic in topics]

    def feed() -> None:
        message = load_message_class(POINT)()
        stamp = message.header.stamp
        stamp.sec, stamp.nanosec = divmod(time.time_ns(), 10**9)
        for each in publishers:
            each.publish(message)

    return feed


def _stop(
    harness: Harness, process: Process, number: signal.Signals, again: float, bag: Path
) -> Ended:
    """Send a signal, another after a while, and wait for the end, samples coming all the time."""
    begin, later = time.monotonic(), after(again)
    process.send(number)
    harness.spin_until(lambda: later() or process.status is not None, "the end")
    process.send(signal.SIGINT)
    harness.spin_until(lambda: process.status is not None, "the end")
    seconds = time.monotonic() - begin
    return Ended(number, process.status, seconds, _messages(bag) if bag.exists() else None)


def _messages(path: Path) -> int:
    """Return how many messages a bag holds.

    Raises:
        AssertionError: It is not whole.
    """
    with open_bag(path) as bag:
        found = sum(1 for _ in bag.messages())
        assert bag.problems == [], (path, bag.problems)
    return found
