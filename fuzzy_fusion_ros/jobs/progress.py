# SPDX-License-Identifier: Apache-2.0
"""How a job shows its progress: not at all, unless its caller passes something that does."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from fuzzy_fusion_ros.bag.block import Block  # takes time to import

T = TypeVar("T")
B = TypeVar("B", bound="Block")


class Progress:
    """Shows no progress; subclasses do."""

    def over(
        self,
        items: Iterable[T],
        text: str,
        total: int | None = None,
        unit: str = "",
        size: Callable[[T], int] = lambda _: 1,
    ) -> Iterable[T]:
        """Return the items, and show progress while they are iterated over.

        Args:
            items: The items.
            text: What is being done with them.
            total: How many there are, where ``len(items)`` is not defined.
            unit: What they are, preceded by a space.
            size: What one item counts as, such as the number of messages in a block.
        """
        return items

    def reading(self, text: str, total: int | None = None) -> Callable[[Iterable[B]], Iterable[B]]:
        """Return a function that passes on blocks of messages and shows how many have been read.

        Args:
            text: What is being done.
            total: How many messages there are, if that is known.
        """
        return lambda blocks: self.over(
            blocks, text, total, " messages", lambda block: block.at.size
        )

    @contextmanager
    def counted(self, text: str, unit: str = "") -> Iterator[Callable[[int, int], None]]:
        """Context manager: yield a function that is called with how much is done, and of how much.

        Args:
            text: What is being done.
            unit: What is counted, preceded by a space.
        """
        yield lambda done, of: None


SILENT = Progress()
"""Shows nothing."""
