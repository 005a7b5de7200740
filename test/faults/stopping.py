"""SIGINT and SIGTERM at random moments in the life of an executable."""

from __future__ import annotations

import functools
import random
import signal
import time
from collections import Counter
from pathlib import Path
from typing import NamedTuple

from faults.waiting import after, as_arguments, wait_until
from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.testing import Harness, Process

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stopped(NamedTuple):
    """How runs ended.

    Attributes:
        statuses: How often each exit status came.
        slowest: The longest time from signal to end, seconds.
    """

    statuses: Counter[int]
    slowest: float


def handles_signals(process: Process) -> bool:
    """Return whether a process has taken over SIGINT and SIGTERM; before, Python itself has them.

    Python handles SIGINT from its own start on, SIGTERM only after the executable has begun.
    """
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = next(line for line in status.splitlines() if line.startswith("SigCgt:"))
    return bool(int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1)


def stop_at_random(folder: Path, times: int, seed: int, longest: float) -> Stopped:
    """Start a recording pendulum_node that waits for nobody, and stop it at a random moment.

    Args:
        folder: For the bags.
        times: How often.
        seed: Of the moments and signals.
        longest: The latest moment after the signals are taken over, seconds.

    Raises:
        AssertionError: It did not end with status 0 and in silence, or its bag is not whole.
    """
    rng, statuses, slowest = random.Random(seed), Counter[int](), 0.0
    with Harness() as harness:
        for k in range(times):
            path = folder / f"{k}"
            settings = {"feedback": "truth", "record": path, "duration": 1e4}
            process = harness.start("pendulum_node", *as_arguments(settings))
            wait_until(functools.partial(handles_signals, process), "signals taken over")
            wait_until(after(rng.uniform(0.0, longest)), "the moment")
            begin = time.monotonic()
            process.send(rng.choice(SIGNALS))
            status = process.wait()
            slowest = max(slowest, time.monotonic() - begin)
            statuses[status] += 1
            assert status == 0, (k, status, process.stderr)
            assert "Traceback" not in process.stderr, process.stderr
            if path.exists():
                with open_bag(path) as bag:
                    list(bag.messages())
                    assert bag.problems == [], (k, bag.problems)
            process.close()
    return Stopped(statuses, slowest)
