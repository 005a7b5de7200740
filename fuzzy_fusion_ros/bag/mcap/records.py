# SPDX-License-Identifier: Apache-2.0
"""The records of an MCAP file.

Messages are split here instead of by mcap's ``StreamReader`` because that takes three times the CPU
time for each (measured by test/bench/bags.py); all other records are mcap's.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from io import BytesIO
from typing import Any, NamedTuple

import zstandard
from mcap.data_stream import ReadDataStream, RecordBuilder
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, ChunkIndex, Footer, McapRecord, Schema, Statistics

MESSAGE = struct.Struct("<BQHIQQ")
"""A message record before its data: opcode, length, channel, sequence, log and publish time."""
MESSAGE_FIELDS = MESSAGE.size - 9
"""What the length of a message record counts besides its data."""
HEAD = struct.Struct("<BQ")
"""What every record begins with: opcode and length of the rest."""

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
    Opcode.CHUNK: Chunk,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.STATISTICS: Statistics,
}


def encode(records: Iterable[McapRecord]) -> bytes:
    """Return records as they stand in a file."""
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())


class Records(NamedTuple):
    """Records that stand one after the other, such as those in a chunk.

    Attributes:
        messages: Log time in ns, order in the file, channel and data of each message.
        others: Opcode and content of each other record.
        is_whole: Whether the last byte ends a record.
    """

    messages: list[tuple[int, int, int, bytes]]
    others: list[tuple[int, bytes]]
    is_whole: bool


MOST_RECORDS = 1_000_000
"""Records of a chunk, or messages outside chunks in a row; those after them are left out."""


def split_records(data: bytes, order: int) -> Records:
    """Split records that stand one after the other; a broken one ends the run.

    Args:
        data: The records.
        order: What to add to the position of a message for its order in the file.
    """
    messages: list[tuple[int, int, int, bytes]] = []
    others: list[tuple[int, bytes]] = []
    position, size = 0, len(data)
    head, message, data_at = HEAD.unpack_from, MESSAGE.unpack_from, MESSAGE.size
    try:
        for _ in range(MOST_RECORDS):
            if position >= size:
                return Records(messages, others, is_whole=True)
            if data[position] == Opcode.MESSAGE:
                _, length, channel, _, log_ns, _ = message(data, position)
                end = position + 9 + length
                if length < MESSAGE_FIELDS or end > size:
                    return Records(messages, others, is_whole=False)
                messages.append((log_ns, order + position, channel, data[position + data_at : end]))
            else:
                opcode, length = head(data, position)
                end = position + 9 + length
                if end > size:
                    return Records(messages, others, is_whole=False)
                if opcode in _KINDS:
                    others.append((opcode, data[position + 9 : end]))
            position = end
    except struct.error:
        return Records(messages, others, is_whole=False)
    return Records(messages, others, is_whole=position == size)


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
