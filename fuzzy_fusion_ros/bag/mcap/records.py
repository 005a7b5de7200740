# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file.

Messages are found here instead of by mcap's ``StreamReader`` because that takes many times the CPU
time for each (measured by test/bench/bags.py); all other records are mcap's.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from io import BytesIO
from typing import Any, NamedTuple

import numpy as np
import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Footer, McapRecord, Schema, Statistics
from numpy.typing import NDArray

from fuzzy_fusion_ros.messages.gather import gathered

MESSAGE = struct.Struct("<BQHIQQ")
"""A message record before its data: opcode, length, channel, sequence, log and publish time."""
MESSAGE_FIELDS = MESSAGE.size - 9
"""What the length of a message record counts besides its data."""
MESSAGE_HEAD = np.dtype(
    {
        "names": ["opcode", "length", "channel", "sequence", "log_ns", "publish_ns"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
    }
)
"""The same as an array has it."""
HEAD = struct.Struct("<BQ")
"""What every record begins with: opcode and length of the rest."""

_MESSAGE = int(Opcode.MESSAGE)

DAMAGE = (
    McapError,
    zstandard.ZstdError,
    struct.error,
    ValueError,
    LookupError,
    OverflowError,
    RuntimeError,
    TypeError,
    MemoryError,
    OSError,
)
"""What mcap and the decompressors and the disk raise on damaged bytes."""

_KINDS: dict[int, Any] = {
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.STATISTICS: Statistics,
}
_NEEDED = {*_KINDS, Opcode.CHUNK_INDEX}


def encode(records: Iterable[McapRecord]) -> bytes:
    """Return records as they stand in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


class Records(NamedTuple):
    """Records that stand one after the other, such as those in a chunk.

    Attributes:
        data: Their bytes.
        places: Where each message record begins, shape (n,).
        others: Opcode and content of each other record.
        is_whole: Whether the last byte ends a record.
    """

    data: bytes
    places: NDArray[np.int64]
    others: list[tuple[int, bytes]]
    is_whole: bool

    def heads(self) -> NDArray[Any]:
        """Return length, channel and log time of each message record, shape (n,)."""
        return gathered(self.data, self.places, MESSAGE_HEAD)


MOST_RECORDS = 1_000_000
"""Records of a chunk, or consecutive messages outside chunks; any more are ignored."""


_CANDIDATES = 2
"""Use arrays only up to this many candidate bytes per message that could fit.

A candidate looks like the start of a message; arrays take 25 bytes for each."""

_PRUNINGS = 3
"""How many passes over candidates drop those that no record leads to, before records are walked."""


def split_records(data: bytes) -> Records:
    """Find the records that stand one after the other; a broken one ends the run."""
    places: list[int] = []
    others: list[tuple[int, bytes]] = []
    position, size = 0, len(data)
    head, last = HEAD.unpack_from, size - HEAD.size
    for _ in range(MOST_RECORDS):
        if position > last:
            break
        opcode, length = head(data, position)
        end = position + 9 + length
        if end > size:
            break
        if opcode == _MESSAGE:
            if length < MESSAGE_FIELDS:
                break
            places.append(position)
        elif opcode in _NEEDED:
            others.append((opcode, data[position + 9 : end]))
        position = end
    return Records(data, np.array(places, np.int64), others, is_whole=position == size)


def find_messages(runs: Sequence[bytes]) -> tuple[bytes, NDArray[np.int64], list[bool]]:
    """Join runs of records and find the messages in them.

    Args:
        runs: The runs, such as the contents of chunks.

    Returns:
        All bytes, where each message record begins in them, shape (n,), and which of the runs are
        whole.
    """
    data = b"".join(runs)
    begins = np.cumsum([0, *map(len, runs)])[:-1]
    places = _nothing_but_messages(data)
    if places is not None and _are_among(begins[[len(run) > 0 for run in runs]], places):
        return data, places, [True] * len(runs)
    split = [split_records(run) for run in runs]
    found = [each.places + begin for each, begin in zip(split, begins, strict=True)]
    return data, np.concatenate(found), [each.is_whole for each in split]


def _are_among(some: NDArray[np.int64], places: NDArray[np.int64]) -> bool:
    """Return whether places, rising, are among others, rising."""
    at = np.searchsorted(places, some)
    return bool((at < places.size).all() and (places[at] == some).all())


def _nothing_but_messages(data: bytes) -> NDArray[np.int64] | None:
    """Return where message records begin if there is nothing else; ``None`` where there may be.

    Each byte that may begin one is looked at, and what none before it leads to is left out. Where
    there are too many of them, there may be something else.
    """
    if data.count(_MESSAGE) > _CANDIDATES * (len(data) // MESSAGE.size):
        return None
    octets = np.frombuffer(data, np.uint8)
    places = np.flatnonzero(octets[: max(0, len(data) - MESSAGE.size + 1)] == _MESSAGE)
    lengths = gathered(data, places + 1, "<u8")
    possible = (lengths >= MESSAGE_FIELDS) & (lengths <= len(data))
    places = places[possible]
    ends = places + HEAD.size + lengths[possible].astype(np.int64)
    for _ in range(_PRUNINGS):
        expected = np.append(0, ends)
        if np.array_equal(expected, np.append(places, len(data))):
            return places if places.size <= MOST_RECORDS else None
        begins = np.zeros(len(data) + 1, np.bool_)
        begins[expected[expected <= len(data)]] = True
        led_to = begins[places]
        places, ends = places[led_to], ends[led_to]
    return None


def decode(opcode: int, content: bytes) -> McapRecord | None:
    """Return the record of an opcode and a content; None for those that nobody here needs.

    Bytes in names that are no UTF-8 are replaced.

    Raises:
        One of ``DAMAGE``: The content is no such record.
    """
    kind = _KINDS.get(opcode)
    return None if kind is None else kind.read(_Stream(BytesIO(content)))


class _Stream(ReadDataStream):
    """Reads a record; a name that is no UTF-8 does not cost the other topics."""

    def read_prefixed_string(self) -> str:
        return self.read(self.read4()).decode(errors="replace")
