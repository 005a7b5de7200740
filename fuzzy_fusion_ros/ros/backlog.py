"""Sheds messages that keep coming faster than they are worked off."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from fuzzy_fusion_ros.ros.node import ConfiguredNode

EVERY = 64
"""Messages after which it is asked whether the executor keeps up."""

LATE = 0.1
"""Seconds after which an answer is late."""


class Backlog:
    """Passes messages on while the executor keeps up, and the newest once it does so again.

    A subscription's queue lets go of its oldest message, but the executor of events keeps a note
    of each that ever came and looks for them one by one. Under a lasting overload these notes
    would fill the memory, and timers and services would wait behind them. So a task is put at
    the end of the executor's queue now and then; while its turn is late, messages are only
    held, each in place of the one before, which takes next to no time.

    Attributes:
        shed: Messages that a newer one took the place of.
    """

    def __init__(self, node: ConfiguredNode[Any], pass_on: Callable[[bytes], None]) -> None:
        self.shed = 0
        self._node = node
        self._pass_on = pass_on
        self._caught_up = node.guarded(self._on_caught_up)
        self._until_asked = EVERY
        self._asked_at: float | None = None
        self._held: bytes | None = None

    def take(self, data: bytes) -> None:
        """Take a message: pass it on, or hold it while others wait."""
        if self._asked_at is not None and time.monotonic() - self._asked_at > LATE:
            self.shed += self._held is not None
            self._held = data
            return
        self._until_asked -= 1
        if self._until_asked <= 0 and self._asked_at is None and self._node.executor is not None:
            self._asked_at = time.monotonic()
            self._node.executor.create_task(self._caught_up)
        self._pass_on(data)

    def _on_caught_up(self) -> None:
        self._asked_at = None
        self._until_asked = EVERY
        held, self._held = self._held, None
        if held is not None:
            self._pass_on(held)
