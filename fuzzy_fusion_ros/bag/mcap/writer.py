# SPDX-License-Identifier: Apache-2.0
"""Writes one MCAP file, chunk by chunk.

Instead of mcap's and rosbags' writers because it takes 0.5 to 0.6 of their CPU time per message,
and because a chunk that a full disk refuses is rolled back, so that the file stays readable
(measured by test/bench/bags.py and test/faults/test_full_disk.py).
"""

from __future__ import annotations

import contextlib
import struct
import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import zstandard
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.writer import MCAP0_MAGIC
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.block import BLOCK_BYTES, Block
from fuzzy_fusion_ros.bag.mcap.records import MESSAGE, MESSAGE_FIELDS, MESSAGE_HEAD, encode
from fuzzy_fusion_ros.messages.gather import gathered, scatter

CHUNK_BYTES = 128 * 1024
CHUNK_SPAN_NS = 1_000_000_000

_LEVEL = 1
"""Of compression: half of the default level's time, at no larger size on recordings of sensors."""

_ENTRY = struct.Struct("<QQ")
"""An entry of a message index: log time and offset."""

_Message = tuple[int, int, bytes]  # channel id, log time in ns, data


@dataclass(frozen=True)
class _Progress:
    """What is on disk, and what is pending; replaced as a whole, so an interrupt cannot tear it."""

    end: int = 0  # of the last complete chunk
    chunks: int = 0
    described: int = 0  # schema and channel records in the file
    counts: Counter[int] = field(default_factory=Counter)
    start_ns: int | None = None
    end_ns: int = 0
    pending: list[_Message] = field(default_factory=list)


class McapWriter:
    """A writer of one MCAP file of the profile ``ros2``.

    A chunk is built in memory, written by one call and only then counted: the file can be
    finished after Ctrl-C in a write, and after SIGKILL every complete chunk is readable. Where a
    chunk ends depends on the calls alone, so the same calls give the same bytes: messages one by
    one make chunks of up to ``CHUNK_BYTES`` and ``CHUNK_SPAN_NS``, a block makes its own chunks,
    of ``BLOCK_BYTES``.
    """

    def __init__(self, path: Path) -> None:
        """Create the file.

        Args:
            path: The file, which must not exist.

        Raises:
            OSError: It cannot be created.
        """
        self._file = path.open("xb", buffering=0)
        self._compressor = zstandard.ZstdCompressor(level=_LEVEL)
        self._descriptions: list[Schema | Channel] = []
        self._chunk_indexes: list[bytes] = []
        self._pending_bytes = 0
        self._progress = _Progress()
        opening = MCAP0_MAGIC + encode([Header("ros2", "fuzzy_fusion_ros")])
        try:
            self._put(0, opening)
        except OSError:
            self._file.close()
            raise
        self._progress = replace(self._progress, end=len(opening))

    @property
    def counts(self) -> Counter[int]:
        """Messages on disk per channel."""
        return self._progress.counts

    @property
    def span_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time on disk; zeros before the first chunk."""
        return self._progress.start_ns or 0, self._progress.end_ns

    @property
    def chunk_count(self) -> int:
        """Chunks on disk."""
        return self._progress.chunks

    def is_closed(self) -> bool:
        """Return whether the file is closed."""
        return self._file.closed

    def add_schema(self, name: str, encoding: str, text: str) -> int:
        """Describe a message type; return the id of the schema."""
        number = 1 + sum(isinstance(each, Schema) for each in self._descriptions)
        self._descriptions.append(Schema(number, text.encode(), encoding, name))
        return number

    def add_channel(self, topic: str, encoding: str, schema: int, metadata: dict[str, str]) -> int:
        """Describe a topic; return the id of the channel."""
        number = 1 + sum(isinstance(each, Channel) for each in self._descriptions)
        self._descriptions.append(Channel(number, topic, encoding, metadata, schema))
        return number

    def write(self, channel: int, log_ns: int, data: bytes) -> bool:
        """Take a message in; return whether that filled and wrote a chunk.

        Raises:
            OSError: The chunk cannot be written; the file still ends with a whole one.
        """
        pending = self._progress.pending
        pending.append((channel, log_ns, data))
        self._pending_bytes += len(data) + MESSAGE.size
        if self._pending_bytes < CHUNK_BYTES and abs(log_ns - pending[0][1]) < CHUNK_SPAN_NS:
            return False
        self.flush()
        return True

    def flush(self) -> None:
        """Write the messages taken in since the last chunk as a chunk.

        Raises:
            OSError: The chunk cannot be written; the file still ends with a whole one.
        """
        done = self._progress
        if not done.pending:
            return
        descriptions = encode(self._descriptions[done.described :])
        self._put_chunk(*_records(descriptions, done.pending))
        self._pending_bytes = 0

    def write_block(self, block: Block, channels: NDArray[np.uint16]) -> bool:
        """Write messages that lie side by side, as chunks of their own; return whether any was.

        Args:
            block: The messages.
            channels: The channel of each, shape (n,).

        Raises:
            OSError: A chunk cannot be written; the file still ends with a whole one.
        """
        self.flush()
        ends = np.cumsum(block.sizes + MESSAGE.size)
        begin, n = 0, ends.size
        while begin < n:
            least = (ends[begin - 1] if begin else 0) + BLOCK_BYTES
            end = min(int(np.searchsorted(ends, least)) + 1, n)
            part = slice(begin, end)
            descriptions = encode(self._descriptions[self._progress.described :])
            self._put_chunk(*_records_of(descriptions, block.chosen(part), channels[part]))
            begin = end
        return n > 0

    def _put_chunk(self, raw: bytes, entries: dict[int, bytes], span_ns: tuple[int, int]) -> None:
        """Write a chunk of all descriptions so far and of messages; nothing is pending after it.

        Args:
            raw: Its records.
            entries: Per channel the log times and offsets of its messages, alternating.
            span_ns: The earliest and the latest log time.

        Raises:
            OSError: It cannot be written; the file still ends with a whole one.
        """
        done = self._progress
        start_ns, end_ns = span_ns
        compressed = self._compressor.compress(raw)
        chunk = Chunk("zstd", compressed, end_ns, start_ns, zlib.crc32(raw), len(raw))
        record = encode([chunk])
        indexes = {each: _message_index(each, places) for each, places in entries.items()}
        data = b"".join([record, *indexes.values()])
        self._put(done.end, data)
        del self._chunk_indexes[done.chunks :]
        self._chunk_indexes.append(encode([_chunk_index(chunk, done.end, len(record), indexes)]))
        counts = {each: len(places) // _ENTRY.size for each, places in entries.items()}
        self._progress = _Progress(
            end=done.end + len(data),
            chunks=done.chunks + 1,
            described=len(self._descriptions),
            counts=done.counts + Counter(counts),
            start_ns=start_ns if done.start_ns is None else min(done.start_ns, start_ns),
            end_ns=max(done.end_ns, end_ns),
        )

    def finish(self, metadata: str) -> None:
        """Write what is pending, then rosbag2's metadata, the summary and the footer.

        Args:
            metadata: The bag's metadata as YAML text, which rosbag2 keeps in the file too.

        Raises:
            OSError: They cannot be written; the file still ends with a whole chunk.
        """
        self.flush()
        done = self._progress
        record = encode([Metadata("rosbag2", {"serialized_metadata": metadata})])
        index = MetadataIndex(done.end, len(record), "rosbag2")
        data = record + encode([DataEnd(0)])
        data += self._summary(done.end + len(data), index) + MCAP0_MAGIC
        self._put(done.end, data)
        self._file.truncate(done.end + len(data))  # an interrupted write may have left more

    def close(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _put(self, position: int, data: bytes) -> None:
        """Write data at a position, all of it or none."""
        self._file.seek(position)
        left = memoryview(data)
        try:
            while left:
                left = left[self._file.write(left) :]
        except OSError:
            with contextlib.suppress(OSError):
                self._file.truncate(position)
            raise

    def _summary(self, start: int, metadata_index: MetadataIndex) -> bytes:
        """Return the summary section, which begins at ``start``, and the footer."""
        done = self._progress
        schemas = [each for each in self._descriptions if isinstance(each, Schema)]
        channels = [each for each in self._descriptions if isinstance(each, Channel)]
        statistics = Statistics(
            attachment_count=0,
            channel_count=len(channels),
            channel_message_counts=dict(sorted(done.counts.items())),
            chunk_count=done.chunks,
            message_count=done.counts.total(),
            message_end_time=done.end_ns,
            message_start_time=done.start_ns or 0,
            metadata_count=1,
            schema_count=len(schemas),
        )
        groups = [
            (Opcode.SCHEMA, encode(schemas)),
            (Opcode.CHANNEL, encode(channels)),
            (Opcode.STATISTICS, encode([statistics])),
            (Opcode.CHUNK_INDEX, b"".join(self._chunk_indexes[: done.chunks])),
            (Opcode.METADATA_INDEX, encode([metadata_index])),
        ]
        body, offsets = b"", list[McapRecord]()
        for opcode, data in groups:
            if data:
                offsets.append(SummaryOffset(opcode, start + len(body), len(data)))
                body += data
        offset_start = start + len(body)
        body += encode(offsets)
        footer = encode([Footer(start, offset_start, 0)])[:-4]
        return body + footer + struct.pack("<I", zlib.crc32(body + footer))


def _records(
    descriptions: bytes, messages: Iterable[_Message]
) -> tuple[bytes, dict[int, bytes], tuple[int, int]]:
    """Return what :meth:`McapWriter._put_chunk` takes, of messages one by one."""
    parts = [descriptions]
    position = len(descriptions)
    entries: dict[int, list[bytes]] = defaultdict(list)
    times = []
    for channel, log_ns, data in messages:
        length = MESSAGE_FIELDS + len(data)
        parts += MESSAGE.pack(Opcode.MESSAGE, length, channel, 0, log_ns, log_ns), data
        entries[channel].append(_ENTRY.pack(log_ns, position))
        times.append(log_ns)
        position += 9 + length
    places = {channel: b"".join(each) for channel, each in entries.items()}
    return b"".join(parts), places, (min(times), max(times))


def _records_of(
    descriptions: bytes, block: Block, channels: NDArray[np.uint16]
) -> tuple[bytes, dict[int, bytes], tuple[int, int]]:
    """Return the same of messages side by side."""
    ends = len(descriptions) + np.cumsum(block.sizes + MESSAGE.size)
    begins = ends - block.sizes - MESSAGE.size
    raw = bytearray(int(ends[-1]))
    raw[: len(descriptions)] = descriptions
    heads = np.zeros(begins.size, MESSAGE_HEAD)
    heads["opcode"] = Opcode.MESSAGE
    heads["length"] = block.sizes + MESSAGE_FIELDS
    heads["channel"] = channels
    heads["log_ns"] = heads["publish_ns"] = block.log_ns
    scatter(raw, begins, heads)
    for size in _different(block.sizes):
        if size:
            own = block.sizes == size
            data = gathered(block.data, block.at[own], f"V{size}")
            scatter(raw, begins[own] + MESSAGE.size, data)
    entries = {}
    for channel in np.flatnonzero(np.bincount(channels)).tolist():
        own = channels == channel
        entries[channel] = np.stack([block.log_ns[own], begins[own]], axis=1).tobytes()
    return bytes(raw), entries, (int(block.log_ns.min()), int(block.log_ns.max()))


def _different(numbers: NDArray[Any]) -> list[int]:
    """Return the numbers that there are, rising; for few of them, faster than ``np.unique``."""
    found = np.sort(numbers)
    return found[np.append(True, found[1:] != found[:-1])].tolist() if found.size else []


def _message_index(channel: int, entries: bytes) -> bytes:
    size = len(entries)
    return struct.pack("<BQHI", Opcode.MESSAGE_INDEX, 2 + 4 + size, channel, size) + entries


def _chunk_index(chunk: Chunk, start: int, length: int, indexes: dict[int, bytes]) -> ChunkIndex:
    offsets = {}
    end = start + length
    for channel, data in indexes.items():
        offsets[channel] = end
        end += len(data)
    return ChunkIndex(
        chunk_length=length,
        chunk_start_offset=start,
        compression=chunk.compression,
        compressed_size=len(chunk.data),
        message_end_time=chunk.message_end_time,
        message_index_length=end - start - length,
        message_index_offsets=offsets,
        message_start_time=chunk.message_start_time,
        uncompressed_size=chunk.uncompressed_size,
    )
