# SPDX-License-Identifier: Apache-2.0
"""Where the messages of an MCAP file without a usable summary are: the whole file is scanned.

Instead of mcap's ``StreamReader`` because that stops at the first damaged byte, where this scan
continues with the next intact chunk (measured by test/bench/bags.py).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import Channel, Schema
from mcap.writer import MCAP0_MAGIC

from fuzzy_fusion_ros.bag import compression
from fuzzy_fusion_ros.bag.mcap.index import (
    CHUNK_FIELDS,
    McapIndex,
    Segment,
    chunk_data,
    read_at,
)
from fuzzy_fusion_ros.bag.mcap.records import DAMAGE, HEAD, MESSAGE, decode, split_records
from fuzzy_fusion_ros.parameters.errors import BagError

_MOST_READINGS = 8
"""How often all of a file may be read without a result: false chunks can overlap."""

_BLOCK_BYTES = 1 << 20
_RUN_BYTES = 1 << 20

# A chunk's length, times, size and checksum, compression, and the length of its records.
_CHUNK = re.compile(
    rb"\x06(.{5}\0{3}).{28}(\0{4}|\x03\0{3}lz4|\x04\0{3}zstd)(.{5}\0{3})", re.DOTALL
)
_CHUNK_HEAD_BYTES = HEAD.size + CHUNK_FIELDS + len("zstd")


class McapScan:
    """Scans a file from its start and continues after whatever is damaged.

    A chunk is intact if it decompresses and its checksum matches. Where records are not in
    chunks, nothing after a damaged length can be found.
    """

    def __init__(self, file: BinaryIO, size: int, note: Callable[[str], None]) -> None:
        """Take a file.

        Args:
            file: An MCAP file.
            size: Its size in bytes.
            note: Told of all that is lost.
        """
        self._file = file
        self._size = size
        self._note = note
        self._index = McapIndex()
        self._counts = Counter[int]()
        self._futile = _MOST_READINGS * size
        self._run_start = 0
        self._run: list[tuple[int, int]] = []

    def index(self) -> McapIndex:
        """Return where the messages are.

        Raises:
            BagError: It neither begins as an MCAP file nor holds a chunk.
        """
        position = len(MCAP0_MAGIC)
        begin = read_at(self._file, 0, position + 1)
        if begin[:position] != MCAP0_MAGIC[: len(begin)]:
            if begin[position:] == bytes([Opcode.HEADER]):
                self._note("its MCAP magic is damaged, what follows is not")
            else:
                position = self._skip(0, "its MCAP magic is damaged")
                if position == self._size:
                    raise BagError(f"it is not an MCAP file: it begins with {begin!r}")
        while position < self._size:
            position = self._read_record(position)
        self._end_run(self._size)
        self._drop_unknown()
        self._index.counts = self._counts
        return self._index

    def _read_record(self, position: int) -> int:
        """Take in the record at a position; return where to go on."""
        head = read_at(self._file, position, HEAD.size)
        if len(head) < HEAD.size:
            return self._skip(position, "a record is truncated")
        opcode, length = HEAD.unpack(head)
        end = position + HEAD.size + int(length)
        if opcode not in Opcode.__members__.values():
            return self._skip(position, "they are not MCAP records")
        if end > self._size or (opcode == Opcode.CHUNK and length > compression.LARGEST):
            return self._skip(position, "a record is truncated")
        if opcode == Opcode.MESSAGE:
            return self._take_message(position, end)
        self._end_run(position)
        if opcode == Opcode.FOOTER:
            return self._size
        try:
            if opcode == Opcode.CHUNK:
                self._take_chunk(position, end)
            elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL}:
                self._describe([(opcode, read_at(self._file, position + HEAD.size, length))])
        except DAMAGE as error:
            self._futile -= end - position
            if self._futile < 0:
                self._note(f"everything from byte {position} on is lost: too much of it is damaged")
                return self._size
            return self._skip(position, f"a {Opcode(opcode).name.lower()} is damaged ({error})")
        return end

    def _take_chunk(self, position: int, end: int) -> None:
        content = read_at(self._file, position + HEAD.size, end - position - HEAD.size)
        run = split_records(chunk_data(content))
        if not run.is_whole:
            self._note(f"the chunk at byte {position} ends within a record")
        self._describe(run.others)
        heads = run.heads()
        found = list(zip(heads["log_ns"].tolist(), heads["channel"].tolist(), strict=True))
        self._add_segment(position, end, found, True)

    def _take_message(self, position: int, end: int) -> int:
        """Add a message outside chunks to the current run of them."""
        head = read_at(self._file, position, MESSAGE.size)
        if end - position < MESSAGE.size:
            return self._skip(position, "a message is damaged")
        _, _, channel, _, log_ns, _ = MESSAGE.unpack(head)
        if not self._run:
            self._run_start = position
        self._run.append((log_ns, channel))
        if end - self._run_start > _RUN_BYTES:
            self._end_run(end)
        return end

    def _end_run(self, end: int) -> None:
        self._add_segment(self._run_start, end, self._run, False)
        self._run = []

    def _add_segment(
        self, start: int, end: int, messages: list[tuple[int, int]], is_chunk: bool
    ) -> None:
        if not messages:
            return
        counts = Counter(channel for _, channel in messages)
        self._counts.update(counts)
        first, last = min(messages)[0], max(messages)[0]
        self._index.span(first, last)
        self._index.segments.append(
            Segment(first, start, end - start, last, frozenset(counts), is_chunk)
        )

    def _describe(self, records: Iterable[tuple[int, bytes]]) -> None:
        for opcode, content in records:
            record = decode(opcode, content)
            if isinstance(record, Schema):
                self._index.schemas.setdefault(record.id, record)
            elif isinstance(record, Channel):
                self._index.channels.setdefault(record.id, record)

    def _drop_unknown(self) -> None:
        unknown = self._counts.keys() - self._index.channels.keys()
        lost = sum(self._counts.pop(channel) for channel in unknown)
        if lost:
            self._note(f"{lost} messages are lost with the descriptions of their topics")

    def _skip(self, position: int, why: str) -> int:
        """Say what is lost from a position on; return where the next whole chunk may be."""
        self._end_run(position)
        found = self._find_chunk(position + 1)
        self._note(f"{found - position} bytes from byte {position} on are lost: {why}")
        return found

    def _find_chunk(self, position: int) -> int:
        """Return where the next chunk begins whose lengths agree; the end if there is none."""
        while position < self._size:
            block = read_at(self._file, position, _BLOCK_BYTES + _CHUNK_HEAD_BYTES)
            at = 0
            while match := _CHUNK.search(block, at):
                length, compression, records = match.groups()
                declared = int.from_bytes(length, "little")
                expected = int.from_bytes(records, "little") + len(compression) - 4 + CHUNK_FIELDS
                end = position + match.start() + HEAD.size + declared
                if declared == expected and end <= self._size:
                    return position + match.start()
                at = match.start() + 1
            position += _BLOCK_BYTES
        return self._size
