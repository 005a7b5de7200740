# SPDX-License-Identifier: Apache-2.0
"""Sheds messages that arrive faster than they are processed."""

from __future__ import annotations

import time

EVERY = 64
"""Messages after which the executor is probed again."""

LATE = 0.1
"""Seconds without an answer to a probe after which the executor is late."""


class Backlog:
    """Holds the newest message while the executor is late.

    A subscription's queue drops its oldest message, but the events executor keeps a note of each
    message that ever came and serves them one by one. Under a lasting overload these notes would
    fill the memory, and timers and services would wait behind them. So now and then a probe is
    put at the end of the executor's queue; while its turn is late, messages are only held, each
    in place of the one before, which takes next to no time.

    Attributes:
        shed: Messages that a newer one replaced.
    """

    def __init__(self) -> None:
        self.shed = 0
        self._until_probe = EVERY
        self._probed_at: float | None = None
        self._held: bytes | None = None

    def holds(self, data: bytes) -> bool:
        """Return whether the executor is late, so that the message is held."""
        if self._probed_at is None or time.monotonic() - self._probed_at <= LATE:
            return False
        self.shed += self._held is not None
        self._held = data
        return True

    def needs_probe(self) -> bool:
        """Return whether a probe is due, and count the message that asks."""
        self._until_probe -= 1
        return self._until_probe <= 0 and self._probed_at is None

    def probed(self) -> None:
        """Take note that a probe is in the executor's queue."""
        self._probed_at = time.monotonic()

    def answered(self) -> bytes | None:
        """Return the message that is held, if any, now that the probe's turn has come."""
        self._probed_at = None
        self._until_probe = EVERY
        held, self._held = self._held, None
        return held
