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

from fuzzy_fusion_ros.bag.mcap.records import MESSAGE, MESSAGE_FIELDS, encode

CHUNK_BYTES = 128 * 1024
CHUNK_SPAN_NS = 1_000_000_000

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
    chunk ends depends on the messages alone: the same messages give the same bytes.
    """

    def __init__(self, path: Path) -> None:
        """Create the file.

        Args:
            path: The file, which must not exist.

        Raises:
            OSError: It cannot be created.
        """
        self._file = path.open("xb", buffering=0)
        self._compressor = zstandard.ZstdCompressor()
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
        descriptions = self._descriptions[done.described :]
        chunk, entries = _build_chunk(descriptions, done.pending, self._compressor)
        record = encode([chunk])
        indexes = {each: _message_index(each, places) for each, places in entries.items()}
        data = b"".join([record, *indexes.values()])
        self._put(done.end, data)
        del self._chunk_indexes[done.chunks :]
        self._chunk_indexes.append(encode([_chunk_index(chunk, done.end, len(record), indexes)]))
        start_ns = chunk.message_start_time
        self._progress = _Progress(
            end=done.end + len(data),
            chunks=done.chunks + 1,
            described=done.described + len(descriptions),
            counts=done.counts
            + Counter({each: len(places) // 2 for each, places in entries.items()}),
            start_ns=start_ns if done.start_ns is None else min(done.start_ns, start_ns),
            end_ns=max(done.end_ns, chunk.message_end_time),
        )
        self._pending_bytes = 0

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


def _build_chunk(
    descriptions: Iterable[Schema | Channel],
    messages: Iterable[_Message],
    compressor: zstandard.ZstdCompressor,
) -> tuple[Chunk, dict[int, list[int]]]:
    """Return a chunk, and per channel the log times and offsets in it, alternating."""
    parts = [encode(descriptions)]
    position = len(parts[0])
    entries: dict[int, list[int]] = defaultdict(list)
    times = []
    for channel, log_ns, data in messages:
        length = MESSAGE_FIELDS + len(data)
        parts += MESSAGE.pack(Opcode.MESSAGE, length, channel, 0, log_ns, log_ns), data
        entries[channel] += log_ns, position
        times.append(log_ns)
        position += 9 + length
    raw = b"".join(parts)
    chunk = Chunk(
        "zstd", compressor.compress(raw), max(times), min(times), zlib.crc32(raw), position
    )
    return chunk, entries


def _message_index(channel: int, places: list[int]) -> bytes:
    size = 8 * len(places)
    return struct.pack(
        f"<BQHI{len(places)}Q", Opcode.MESSAGE_INDEX, 2 + 4 + size, channel, size, *places
    )


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
