# SPDX-License-Identifier: Apache-2.0
"""Messages side by side: their bytes in one buffer, and arrays that say what is where."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.topic import BagMessage

Kinds = tuple[tuple[str, str], ...]
"""Topics, each with a type of its messages."""

BLOCK_BYTES = 1 << 20
"""Bytes of a block that is worth arrays."""

_GATHERED = 1 << 12
"""Messages, at most, of a block where a bag has them one by one."""


class Block(NamedTuple):
    """Messages in the order in which they are read.

    Attributes:
        data: The buffer.
        at: Where each message begins in it, shape (n,).
        sizes: How many bytes each has, shape (n,).
        log_ns: When each was recorded, shape (n,), nanoseconds.
        kinds: What each is, as an index of ``names``, shape (n,).
        names: Topics and types.
    """

    data: bytes
    at: NDArray[np.int64]
    sizes: NDArray[np.int64]
    log_ns: NDArray[np.int64]
    kinds: NDArray[np.int64]
    names: Kinds

    def messages(self) -> Iterator[BagMessage]:
        """Yield them one by one."""
        data, names = self.data, self.names
        ends = self.at + self.sizes
        for at, end, log_ns, kind in zip(
            self.at.tolist(), ends.tolist(), self.log_ns.tolist(), self.kinds.tolist(), strict=True
        ):
            name, msgtype = names[kind]
            yield BagMessage(name, msgtype, log_ns, data[at:end])

    def chosen(self, which: NDArray[np.bool_] | NDArray[np.int64] | slice) -> Block:
        """Return some of them; the buffer stays as it is."""
        return self._replace(
            at=self.at[which],
            sizes=self.sizes[which],
            log_ns=self.log_ns[which],
            kinds=self.kinds[which],
        )

    def compact(self) -> Block:
        """Return the messages in a buffer of which they take at least half."""
        if 2 * int(self.sizes.sum()) >= len(self.data):
            return self
        data, ends = memoryview(self.data), self.at + self.sizes
        pieces = [data[at:end] for at, end in zip(self.at.tolist(), ends.tolist(), strict=True)]
        return Block(
            b"".join(pieces),
            np.cumsum(self.sizes) - self.sizes,
            self.sizes.copy(),
            self.log_ns.copy(),
            self.kinds.copy(),
            self.names,
        )

    def on(self, topic: str) -> Block:
        """Return the messages of a topic."""
        return self.chosen(self.which(topic))

    def which(self, topic: str) -> NDArray[np.int64]:
        """Return which of the messages are of a topic, rising."""
        of_topic = np.array([name == topic for name, _ in self.names], np.bool_)
        return np.flatnonzero(of_topic[self.kinds])


def one_by_one(blocks: Iterable[Block]) -> Iterator[BagMessage]:
    """Yield the messages of blocks."""
    for block in blocks:
        yield from block.messages()


def first(blocks: Iterable[Block], most: int) -> Iterator[Block]:
    """Yield blocks up to a number of messages."""
    for block in blocks:
        yield block.chosen(slice(most))
        most -= block.at.size
        if most <= 0:
            return


def gathered(messages: Iterable[BagMessage]) -> Iterator[Block]:
    """Yield messages that come one by one as blocks.

    A block ends with the message that fills it: ``BLOCK_BYTES`` or 4096 messages.
    """
    found: list[BagMessage] = []
    size = 0
    for message in messages:
        found.append(message)
        size += len(message.data)
        if size >= BLOCK_BYTES or len(found) == _GATHERED:
            yield _joined(found)
            found, size = [], 0
    if found:
        yield _joined(found)


def _joined(messages: Sequence[BagMessage]) -> Block:
    numbers: dict[tuple[str, str], int] = {}
    kinds = [numbers.setdefault(each[:2], len(numbers)) for each in messages]
    sizes = np.array([len(each.data) for each in messages], np.int64)
    return Block(
        b"".join(each.data for each in messages),
        np.cumsum(sizes) - sizes,
        sizes,
        np.array([each.log_ns for each in messages], np.int64),
        np.array(kinds, np.int64),
        tuple(numbers),
    )


def together(blocks: Sequence[Block]) -> Block:
    """Return blocks of the same topics as one, at least one of them."""
    if len(blocks) == 1:
        return blocks[0]
    begins = np.cumsum([0, *(len(each.data) for each in blocks[:-1])])
    return Block(
        b"".join(each.data for each in blocks),
        np.concatenate([each.at + begin for each, begin in zip(blocks, begins, strict=True)]),
        np.concatenate([each.sizes for each in blocks]),
        np.concatenate([each.log_ns for each in blocks]),
        np.concatenate([each.kinds for each in blocks]),
        blocks[0].names,
    )
