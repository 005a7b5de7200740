# SPDX-License-Identifier: Apache-2.0
"""Where the messages of an MCAP file are, as its summary says.

Instead of mcap's ``get_summary`` because that trusts offsets, counts and times that cannot be
true, and fails on the first record that is damaged (measured by test/bag/test_damage.py).
"""

from __future__ import annotations

import struct
import zlib
from collections import Counter
from dataclasses import dataclass, field
from typing import BinaryIO, NamedTuple

from mcap.opcode import Opcode
from mcap.records import Channel, Schema, Statistics
from mcap.writer import MCAP0_MAGIC

from fuzzy_fusion_ros.bag.compression import decompress
from fuzzy_fusion_ros.bag.mcap.records import DAMAGE, HEAD, decode, split_records

CHUNK_FIELDS = 8 + 8 + 8 + 4 + 4 + 8
"""What the length of a chunk counts besides the name of its compression and its data."""

_CHUNK = struct.Struct("<QQQII")
"""A chunk's times, size and checksum when decompressed, and the length of its compression's name"""
_LENGTH = struct.Struct("<Q")
_CHUNK_INDEX = struct.Struct("<QQQQI")
"""A chunk's times, its begin and length, and the length of what says where its indexes are."""
_INDEX_ENTRY = 2 + 8
"""Bytes of an entry of that: a channel, and where its index is."""
_FOOTER = struct.Struct("<QQI")
_TAIL_BYTES = HEAD.size + _FOOTER.size + len(MCAP0_MAGIC)


class Segment(NamedTuple):
    """A stretch of the file with messages; segments sort by time, then by place.

    Attributes:
        start_ns: The earliest log time in it, ns.
        offset: Its first byte.
        length: Its bytes.
        end_ns: The latest log time in it, ns.
        channels: The channels in it; None if they are not known.
        is_chunk: Whether it is one chunk record, else a run of message records.
    """

    start_ns: int
    offset: int
    length: int
    end_ns: int
    channels: frozenset[int] | None
    is_chunk: bool


@dataclass
class McapIndex:
    """What an MCAP file holds, and where.

    Attributes:
        schemas: Message definitions by their ids.
        channels: Topics by their ids.
        segments: Where messages are.
        counts: Messages per channel; None if they are not known.
        start_ns: The earliest log time, ns; None without messages.
        end_ns: The latest log time, ns; None without messages.
    """

    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    segments: list[Segment] = field(default_factory=list)
    counts: Counter[int] | None = None
    start_ns: int | None = None
    end_ns: int | None = None

    def span(self, start_ns: int, end_ns: int) -> None:
        """Widen the time span to include another one."""
        self.start_ns = start_ns if self.start_ns is None else min(self.start_ns, start_ns)
        self.end_ns = end_ns if self.end_ns is None else max(self.end_ns, end_ns)


class SummaryError(Exception):
    """The file has no summary that can be used.

    Attributes:
        is_damage: Whether that means that something is wrong with the file.
    """

    def __init__(self, reason: str, *, is_damage: bool = True) -> None:
        super().__init__(reason)
        self.is_damage = is_damage


def read_at(file: BinaryIO, position: int, length: int) -> bytes:
    """Return the bytes at a position; fewer at the end of the file."""
    file.seek(position)
    return file.read(length)


def index_from_summary(file: BinaryIO, size: int) -> McapIndex:
    """Return the index that the summary at the end of a file gives.

    Args:
        file: An MCAP file.
        size: Its size in bytes.

    Raises:
        SummaryError: There is no summary, it is damaged, or it lacks what is needed.
    """
    tail = read_at(file, max(0, size - _TAIL_BYTES), _TAIL_BYTES)
    if not tail.endswith(MCAP0_MAGIC) or not tail.startswith(HEAD.pack(Opcode.FOOTER, 20)):
        raise SummaryError("it is incomplete: the recorder was killed or the copy was cut off")
    start, _, checksum = _FOOTER.unpack_from(tail, HEAD.size)
    if start == 0:
        raise SummaryError("it has no summary", is_damage=False)
    if start > size - _TAIL_BYTES:
        raise SummaryError("its summary is damaged")
    data = read_at(file, start, size - _TAIL_BYTES - start)
    covered = tail[: HEAD.size + _FOOTER.size - 4]
    if checksum and zlib.crc32(data + covered) != checksum:
        raise SummaryError("its summary is damaged")
    return _index_from_records(data, start)


def chunk_data(content: bytes) -> bytes:
    """Return what a chunk holds, decompressed, its checksum checked.

    Args:
        content: The chunk's record after opcode and length.

    Raises:
        One of ``DAMAGE``: The chunk is damaged, too large, or its compression is unknown.
    """
    _, _, size, checksum, name_length = _CHUNK.unpack_from(content)
    begin = _CHUNK.size + name_length
    (length,) = _LENGTH.unpack_from(content, begin)
    if CHUNK_FIELDS + name_length + length != len(content):
        raise ValueError("its lengths are inconsistent")
    compression = content[_CHUNK.size : begin].decode()
    data = decompress(compression, content[begin + _LENGTH.size :], size)
    if len(data) != size:
        raise ValueError(f"it holds {len(data)} bytes instead of {size}")
    if checksum and zlib.crc32(data) != checksum:
        raise ValueError("its checksum does not match")
    return data


def _index_from_records(data: bytes, limit: int) -> McapIndex:
    """Return the index in the records of a summary that begins at byte ``limit``."""
    index = McapIndex()
    statistics = None
    known: dict[frozenset[int], frozenset[int]] = {}
    run = split_records(data)
    if not run.is_whole:
        raise SummaryError("its summary is damaged")
    try:
        for opcode, content in run.others:
            if opcode == Opcode.CHUNK_INDEX:
                index.segments.append(_segment(content, limit, known))
                continue
            record = decode(opcode, content)
            if isinstance(record, Schema):
                index.schemas[record.id] = record
            elif isinstance(record, Channel):
                index.channels[record.id] = record
            elif isinstance(record, Statistics):
                statistics = record
    except DAMAGE as error:
        raise SummaryError(f"its summary is damaged ({error})") from error
    _take_statistics(index, statistics)
    return index


def _segment(content: bytes, limit: int, known: dict[frozenset[int], frozenset[int]]) -> Segment:
    """Return what the index of a chunk says; chunks by the thousand hold the same topics."""
    start_ns, end_ns, start, length, size = _CHUNK_INDEX.unpack_from(content)
    if start + length > limit:
        raise ValueError("it places a chunk outside the file")
    entries = content[_CHUNK_INDEX.size : _CHUNK_INDEX.size + size]
    if len(entries) != size:
        raise ValueError("the index of a chunk is cut off")
    if size % _INDEX_ENTRY:
        raise ValueError("the index of a chunk is cut off")
    numbers = entries[::_INDEX_ENTRY], entries[1::_INDEX_ENTRY]
    found = frozenset(low + 256 * high for low, high in zip(*numbers, strict=True))
    channels = known.setdefault(found, found)
    return Segment(start_ns, start, length, end_ns, channels or None, is_chunk=True)


def _take_statistics(index: McapIndex, statistics: Statistics | None) -> None:
    """Add counts and the time span; refuse a summary that leaves messages or topics out."""
    used = {channel for each in index.segments for channel in each.channels or ()}
    if statistics is not None:
        index.counts = Counter(statistics.channel_message_counts)
        used |= {channel for channel, count in index.counts.items() if count}
    if not index.segments and (statistics is None or statistics.message_count > 0):
        raise SummaryError("its summary lists no chunks", is_damage=False)
    known = index.channels.keys()
    schemas = index.schemas.keys() | {0}
    if used - known or (index.segments and not known):
        raise SummaryError("its summary does not list every topic", is_damage=False)
    if any(channel.schema_id not in schemas for channel in index.channels.values()):
        raise SummaryError("its summary does not list every type", is_damage=False)
    if statistics is None:
        for each in index.segments:
            index.span(each.start_ns, each.end_ns)
    elif statistics.message_count > 0:
        index.span(statistics.message_start_time, statistics.message_end_time)
