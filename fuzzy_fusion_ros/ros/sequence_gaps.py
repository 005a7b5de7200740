"""Counts the messages that a subscription never got to see."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any


class SequenceGapCounter:
    """Counts gaps in the numbers that a publisher gives its messages.

    Messages are lost when they come faster than the node takes them (the newest stay), or on
    the way. With several publishers on a topic their numbers cannot be told apart: what the
    middleware itself reports is left then.
    """

    def __init__(self) -> None:
        self._gaps = 0
        self._reported = 0
        self._last: int | None = None

    @property
    def count(self) -> int:
        """Messages lost so far."""
        return max(self._gaps, self._reported)

    def see(self, number: int | None, publishers: Callable[[], int]) -> None:
        """Take the number of a message that came in.

        Args:
            number: The publisher's count, from 1; ``None`` where the middleware has none.
            publishers: Tells how many publishers there are; asked at gaps only.
        """
        last, self._last = self._last, number
        if last is None or number is None or number <= last + 1:
            return
        if publishers() <= 1:
            self._gaps += number - last - 1

    def report(self, total: int) -> None:
        """Take the middleware's own count."""
        self._reported = total


class WithNumber:
    """Makes a callback of ``(message, number)`` one that rclpy calls with message info.

    The events executor of Jazzy hands a callback that asks for message info one tuple instead
    of two arguments; other executors give two. This takes both.
    """

    __signature__ = inspect.signature(lambda message, info: None)

    def __init__(self, callback: Callable[[Any, int | None], None]) -> None:
        self._callback = callback

    def __call__(self, message: Any, info: Any = None) -> None:
        """Pass on the message and its publication number."""
        if info is None:
            message, info = message
        number = info["publication_sequence_number"]
        self._callback(message, number)
