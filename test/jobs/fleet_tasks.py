# SPDX-License-Identifier: Apache-2.0
"""Tasks for other processes, which import them by name."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from fuzzy_fusion_ros.jobs.fleet import STOP
from fuzzy_fusion_ros.parameters.errors import FusionError


def square(number: int) -> int:
    """Return the square; 3 is refused, and 4 kills the process."""
    if number == 3:
        raise FusionError("got 3,\nexpected anything else")
    if number == 4:
        os._exit(1)
    return number * number


def gated(item: tuple[int, str]) -> int:
    """Write down this process, wait until the gate is open, return the square."""
    number, folder = item
    with Path(folder, "started").open("a") as file:
        file.write(f"{os.getpid()}\n")
    with Path(folder, "gate").open("rb"):  # a FIFO: opens once somebody writes to it
        return number * number


def waiting(item: tuple[int, str]) -> int:
    """Return the square of an even number; for an odd one, write that it waits, and do."""
    number, folder = item
    if number % 2:
        try:
            Path(folder, f"waits_{number}_{os.getpid()}").touch()
            signal.pause()
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"{number} has waited") from None
    return number * number


def interrupted_twice(_: int) -> None:
    """Get both signals that interrupt a task at once; unwind."""
    both = {STOP, signal.SIGTERM}
    signal.pthread_sigmask(signal.SIG_BLOCK, both)
    for each in both:
        signal.raise_signal(each)  # to this thread
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, both)
        signal.pause()
    except KeyboardInterrupt:
        raise KeyboardInterrupt("unwound") from None


def lost_in_a_lock(_: int) -> None:
    """Get the signal that interrupts a task where it becomes another error, which it does."""
    try:
        os.kill(os.getpid(), STOP)
        signal.pause()
    except KeyboardInterrupt:
        raise RuntimeError("release unlocked lock") from None


def noted(item: tuple[int, str]) -> int:
    """Write that it has begun, return the square."""
    number, folder = item
    Path(folder, str(number)).touch()
    return number * number
