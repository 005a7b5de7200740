# SPDX-License-Identifier: Apache-2.0
"""Counts the messages that a subscription never received."""

from __future__ import annotations


class SequenceGapCounter:
    """Counts gaps in the sequence numbers that a publisher gives its messages.

    Messages are lost where the queue overflows or in transit. With several publishers on a topic
    their numbers cannot be distinguished; only what the middleware reports remains then.
    """

    def __init__(self) -> None:
        self._gaps = 0
        self._reported = 0
        self._last: int | None = None

    @property
    def count(self) -> int:
        """Messages lost so far."""
        return max(self._gaps, self._reported)

    def before(self, number: int | None) -> int:
        """Return how many numbers are missing between the last message and this one.

        Args:
            number: The publisher's number, from 1; ``None`` where the middleware has none.
        """
        last, self._last = self._last, number
        if last is None or number is None:
            return 0
        return max(number - last - 1, 0)

    def add(self, messages: int) -> None:
        """Count messages as lost."""
        self._gaps += messages

    def report(self, total: int) -> None:
        """Take over the middleware's own count."""
        self._reported = total
