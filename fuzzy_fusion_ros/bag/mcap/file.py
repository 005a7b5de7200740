# SPDX-License-Identifier: Apache-2.0
"""Reads the messages of one MCAP file, intact or damaged, in the order of their log times.

Instead of mcap's and rosbags' readers because these stop at the first damaged byte, where this one
skips one chunk, and because it takes 0.6 of rosbags' CPU time per message and 0.2 to 0.3 of mcap's
(measured by test/bench/bags.py).
"""

from __future__ import annotations

import contextlib
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from mcap.opcode import Opcode
from mcap.records import Channel
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag.block import BLOCK_BYTES, Block, one_by_one, together
from fuzzy_fusion_ros.bag.mcap.index import (
    McapIndex,
    Segment,
    SummaryError,
    chunk_data,
    index_from_summary,
    read_at,
)
from fuzzy_fusion_ros.bag.mcap.records import (
    DAMAGE,
    HEAD,
    MESSAGE,
    MESSAGE_FIELDS,
    MESSAGE_HEAD,
    find_messages,
)
from fuzzy_fusion_ros.bag.mcap.scan import McapScan
from fuzzy_fusion_ros.bag.metadata import MetadataError, qos_from_text
from fuzzy_fusion_ros.bag.topic import MOST_TOPICS, BagMessage, Definition, Topic
from fuzzy_fusion_ros.messages.gather import gathered
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

_ORDER_BITS = 32  # messages are ordered by their segment, then by their place in it


class _Ordered(NamedTuple):
    """Messages in order, and what orders those of equal log times, shape (n,)."""

    block: Block
    rank: NDArray[np.int64]

    def chosen(self, which: NDArray[np.int64] | slice) -> _Ordered:
        """Return some of them; the buffer stays as it is."""
        return _Ordered(self.block.chosen(which), self.rank[which])

    def compact(self) -> _Ordered:
        """Return them in a buffer of which they take at least half."""
        return _Ordered(self.block.compact(), self.rank.copy())


def _split(runs: Iterable[_Ordered], limit_ns: int) -> tuple[list[_Ordered], list[_Ordered]]:
    """Return the messages before a log time, and those from it on, which have to wait."""
    before, waiting = [], []
    for run in runs:
        log_ns = run.block.log_ns
        first = int(np.searchsorted(log_ns, limit_ns))
        if first:
            before.append(run.chosen(slice(first)))
        if first < log_ns.size:
            waiting.append(run.chosen(slice(first, None)).compact())
    return before, waiting


def _merged(runs: Sequence[_Ordered]) -> Block:
    """Return the messages of at least one run in order; each is copied at most once."""
    if len(runs) == 1:
        return runs[0].block
    compact = [run.compact() for run in runs]
    block = together([run.block for run in compact])
    return _in_order(_Ordered(block, np.concatenate([run.rank for run in compact]))).block


def _in_order(found: _Ordered) -> _Ordered:
    steps = np.diff(found.block.log_ns)
    if not ((steps < 0) | ((steps == 0) & (np.diff(found.rank) < 0))).any():
        return found
    order = np.lexsort((found.rank, found.block.log_ns))
    return _Ordered(found.block.chosen(order), found.rank[order])


class _Loaded(NamedTuple):
    """A segment and its records."""

    segment: Segment
    data: bytes


class _Group(NamedTuple):
    """Segments that are read together.

    Attributes:
        end: The place of the first segment after them.
        segments: The segments.
        messages: All their messages, of kinds that are the numbers of channels.
    """

    end: int
    segments: list[Segment]
    messages: _Ordered

    def on(self, kinds: NDArray[np.int64], start_ns: int, stop_ns: int) -> _Ordered:
        """Return some of the messages.

        Args:
            kinds: Of the messages of each channel, negative for those that are left out.
            start_ns: Log times begin here, ns.
            stop_ns: Log times end before this, ns.
        """
        block, rank = self.messages
        of, log_ns = kinds[block.kinds], block.log_ns
        there = (of >= 0) & (log_ns >= start_ns) & (log_ns < stop_ns)
        found = _Ordered(block._replace(kinds=of), rank)
        return found if there.all() else found.chosen(np.flatnonzero(there))


class McapFile:
    """One MCAP file.

    It is read chunk by chunk: those that the summary lists, else those that a scan of the whole
    file finds. A damaged chunk is skipped.

    Attributes:
        topics: What the file holds.
        start_ns: The earliest log time, ns; None without messages.
        end_ns: The latest log time, ns; None without messages.
    """

    def __init__(self, path: Path, note: Callable[[str], None]) -> None:
        """Open a file and find its messages.

        Args:
            path: The file.
            note: Told of all that is not whole, now and while messages are read.

        Raises:
            BagError: It cannot be read or is no MCAP file.
        """
        self._note = note
        try:
            self._file = path.open("rb")
        except OSError as error:
            raise BagError(f"{str(path)!r} cannot be read: {error.strerror}") from error
        try:
            self._index = self._find_messages(path.stat().st_size)
            self._channels = self._topics()
        except OSError as error:
            self._file.close()
            raise BagError(f"{str(path)!r} cannot be read: {error.strerror}") from error
        except BagError as error:
            self._file.close()
            raise BagError(f"{str(path)!r}: {error}") from error
        self._segments = sorted(self._index.segments)
        self._kept: dict[int, _Group] = {}
        self._unknown = max(self._channels, default=-1) + 1  # channel of unknown messages
        places = sorted(each.offset for each in self._segments)
        self._ranks = {place: rank << _ORDER_BITS for rank, place in enumerate(places)}
        self.topics = list(self._channels.values())
        self._names = tuple((each.name, each.msgtype) for each in self.topics)
        self.start_ns = self._index.start_ns
        self.end_ns = self._index.end_ns

    def close(self) -> None:
        """Close the file."""
        self._file.close()
        self._kept.clear()

    def messages(
        self, names: Collection[str] | None, start_ns: int, stop_ns: int
    ) -> Iterator[BagMessage]:
        """Return the messages of :meth:`blocks` one by one."""
        return one_by_one(self.blocks(names, start_ns, stop_ns))

    def blocks(self, names: Collection[str] | None, start_ns: int, stop_ns: int) -> Iterator[Block]:
        """Yield messages in the order of their log times, equal ones in that of the file.

        A block comes as soon as no later segment can come before its end.

        Args:
            names: The topics; None for all.
            start_ns: Log times begin here, ns.
            stop_ns: Log times end before this, ns.

        Raises:
            BagError: The file was closed in between.
        """
        kinds = np.full(self._unknown + 1, -1, np.int64)
        for kind, (number, topic) in enumerate(self._channels.items()):
            if names is None or topic.name in names:
                kinds[number] = kind
        waiting: list[_Ordered] = []
        wanted = set(np.flatnonzero(kinds >= 0).tolist())

        def is_due(each: Segment) -> bool:
            return each.end_ns >= start_ns and not (
                each.channels and each.channels.isdisjoint(wanted)
            )

        for group in self._groups(is_due, stop_ns):
            before, waiting = _split(waiting, group.segments[0].start_ns)
            if before:
                yield _merged(before)
            waiting.append(group.on(kinds, start_ns, stop_ns))
            del group, before  # what is yielded need not be in memory with what is read next
        if waiting:
            yield _merged(waiting)

    def _find_messages(self, size: int) -> McapIndex:
        try:
            return index_from_summary(self._file, size)
        except SummaryError as error:
            if error.is_damage:
                self._note(str(error) if size else "it is empty")
            return McapScan(self._file, size, self._note).index()

    def _groups(self, is_due: Callable[[Segment], bool], stop_ns: int) -> Iterator[_Group]:
        """Yield segments: one, then the rest in batches large enough for arrays."""
        begin, size = 0, 0
        end = bisect_left(self._segments, (stop_ns,))
        while begin < end:
            group = self._kept.get(begin)
            due = [] if group is None else filter(is_due, self._segments[begin : group.end])
            if group is None or group.segments != list(due):
                group = self._group(is_due, begin, end, size)
                self._keep(begin, group)
            if group.segments:
                yield group
            begin, size = group.end, BLOCK_BYTES

    def _keep(self, begin: int, group: _Group) -> None:
        """Keep what a file begins with: first messages, samples and a check all read it."""
        kept = [len(each.messages.block.data) for each in self._kept.values()]
        follows = begin == max((each.end for each in self._kept.values()), default=0)
        if follows and sum(kept) + len(group.messages.block.data) <= BLOCK_BYTES:
            self._kept[begin] = group

    def _group(self, is_due: Callable[[Segment], bool], begin: int, end: int, size: int) -> _Group:
        """Read segments, at least one if there is one, until they have a number of bytes."""
        found: list[_Loaded] = []
        at = begin
        while at < end and (not found or size > 0):
            if is_due(self._segments[at]):
                found.append(_Loaded(self._segments[at], self._load(self._segments[at])))
                size -= len(found[-1].data)
            at += 1
        return _Group(at, [each.segment for each in found], self._ordered(found))

    def _ordered(self, group: Sequence[_Loaded]) -> _Ordered:
        """Return the messages of segments in order."""
        contents = [each.data for each in group]
        data, places, whole = find_messages(contents)
        heads = gathered(data, places, MESSAGE_HEAD)
        begins = np.cumsum([0, *map(len, contents)])
        of_segment = np.searchsorted(begins[1:], places, side="right")
        log_ns = heads["log_ns"]
        early = log_ns < np.array([each.segment.start_ns for each in group], np.uint64)[of_segment]
        out_of_order = set(of_segment[early].tolist())
        for k, (segment, _) in enumerate(group):
            if k in out_of_order:
                self._note_on(
                    segment, "also holds earlier messages: messages may come out of order"
                )
            if not whole[k]:
                self._note_on(segment, "ends within a record")
        ranks = np.array([self._ranks[each.segment.offset] for each in group], np.int64)
        rank = (ranks - begins[:-1])[of_segment] + places
        sizes = heads["length"].astype(np.int64) - MESSAGE_FIELDS
        times = log_ns.astype(np.int64)
        of = np.minimum(heads["channel"].astype(np.int64), self._unknown)
        block = Block(data, places + MESSAGE.size, sizes, times, of, self._names)
        return _in_order(_Ordered(block, rank))

    def _load(self, segment: Segment) -> bytes:
        """Return the records of a segment; none if it is damaged."""
        if self._file.closed:
            raise BagError(f"{self._file.name!r} was closed while it was being read")
        try:
            data = read_at(self._file, segment.offset, segment.length)
            if segment.is_chunk:
                if not data.startswith(HEAD.pack(Opcode.CHUNK, segment.length - HEAD.size)):
                    raise ValueError("no chunk there")
                data = chunk_data(data[HEAD.size :])
        except DAMAGE as error:
            self._note_on(segment, f"is damaged and skipped ({error})")
            return b""
        return data

    def _note_on(self, segment: Segment, problem: str) -> None:
        self._note(
            f"the chunk at byte {segment.offset}, log times {segment.start_ns} to "
            f"{segment.end_ns} ns, {problem}"
        )

    def _topics(self) -> dict[int, Topic]:
        channels = self._index.channels
        if len(channels) > MOST_TOPICS:
            raise BagError(f"it has more than {MOST_TOPICS} topics")
        return {number: self._topic(number, each) for number, each in channels.items()}

    def _topic(self, number: int, channel: Channel) -> Topic:
        schema = self._index.schemas.get(channel.schema_id)
        msgtype, definition = schema.name if schema else "", None
        with contextlib.suppress(MessageError):
            msgtype = normalise_type_name(msgtype)
        if schema:
            digest = channel.metadata.get("topic_type_hash", "")
            text = schema.data.decode(errors="replace")
            definition = Definition(schema.encoding, text, digest)
        try:
            qos = qos_from_text(channel.metadata.get("offered_qos_profiles", ""))
        except MetadataError as error:
            self._note(f"topic {channel.topic}: {error}")
            qos = ()
        counts = self._index.counts
        return Topic(
            channel.topic,
            msgtype,
            None if counts is None else counts[number],
            definition,
            qos,
            channel.message_encoding,
        )
