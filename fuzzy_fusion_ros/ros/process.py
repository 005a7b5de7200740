# SPDX-License-Identifier: Apache-2.0
"""Runs one node as a process: start-up, spinning, and orderly shutdown."""

from __future__ import annotations

import atexit
import functools
import gc
import os
import signal
from collections.abc import Callable, Sequence
from types import FrameType
from typing import Any

POLL = 0.1
"""Longest wait of the executor, seconds: a signal is seen after it at the latest."""

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class Stop:
    """Context manager: SIGINT and SIGTERM request a stop.

    No exception is raised out of the middle of anything. Before there is anything to close,
    :meth:`at_once` lets a signal end the process on the spot: imports and discovery take
    longer than a user, or a supervisor, wants to wait. Signals that come while the process ends
    already are ignored, also by Python's own end: it takes long, and the system would kill it.
    """

    def __init__(self) -> None:
        self.wanted = False
        self._at_once = True

    def __enter__(self) -> Stop:
        """Take over the signals."""
        self._before = [signal.signal(number, self._on_signal) for number in SIGNALS]
        self._wakeup = signal.set_wakeup_fd(-1)  # nobody else is to end the process meanwhile
        atexit.unregister(_end_undisturbed)
        atexit.register(_end_undisturbed)
        return self

    def __exit__(self, *_: object) -> None:
        """Give the signals back, unless one has come."""
        signal.set_wakeup_fd(self._wakeup)
        for number, handler in zip(SIGNALS, self._before, strict=True):
            signal.signal(number, signal.SIG_IGN if self.wanted else handler)

    def in_order(self) -> None:
        """From now on there is something to close."""
        self._at_once = False

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self._at_once:
            os._exit(0)
        self.wanted = True


def _end_undisturbed() -> None:
    """Let Python's own end ignore signals and not look for garbage, which takes half of it."""
    gc.freeze()
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def run(
    stop: Stop, load: Callable[[], Callable[..., Any]], arguments: Sequence[str], **options: Any
) -> None:
    """Run a node until it says that it has finished, or SIGINT or SIGTERM come.

    Args:
        stop: Has taken over the signals.
        load: Imports and returns the node's class.
        arguments: The arguments of the process that are for ROS.
        options: Of the node.

    Raises:
        FusionError: The node cannot be set up with these arguments, or what it needs is gone.
    """
    make_node = load()
    from fuzzy_fusion_ros.ros.spinning import spin

    stop.in_order()
    spin(functools.partial(make_node, **options), arguments, lambda: stop.wanted, POLL)
