# SPDX-License-Identifier: Apache-2.0
"""Reads the messages of one MCAP file, intact or damaged, in the order of their log times.

Instead of mcap's and rosbags' readers because these stop at the first damaged byte, where this one
skips one chunk, and because it takes 0.6 of rosbags' CPU time per message and 0.2 to 0.3 of mcap's
(measured by test/bench/bags.py).
"""

from __future__ import annotations

import contextlib
from bisect import bisect_left
from collections.abc import Callable, Collection, Iterator, Set
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Channel

from fuzzy_fusion_ros.bag.mcap.index import (
    McapIndex,
    Segment,
    SummaryError,
    chunk_data,
    index_from_summary,
    read_at,
)
from fuzzy_fusion_ros.bag.mcap.records import DAMAGE, HEAD, Records, split_records
from fuzzy_fusion_ros.bag.mcap.scan import McapScan
from fuzzy_fusion_ros.bag.metadata import MetadataError, qos_from_text
from fuzzy_fusion_ros.bag.topic import MOST_TOPICS, BagMessage, Definition, Topic
from fuzzy_fusion_ros.messages.type_names import normalise_type_name
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError

_ORDER_BITS = 32  # messages are ordered by their segment, then by their place in it
_Entry = tuple[int, int, int, bytes]


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
        self.topics = list(self._channels.values())
        self.start_ns = self._index.start_ns
        self.end_ns = self._index.end_ns

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def messages(
        self, names: Collection[str] | None, start_ns: int, stop_ns: int
    ) -> Iterator[BagMessage]:
        """Yield messages in the order of their log times, equal ones in that of the file.

        Args:
            names: The topics; None for all.
            start_ns: Log times begin here, ns.
            stop_ns: Log times end before this, ns.

        Raises:
            BagError: The file was closed in between.
        """
        wanted = {
            channel: (topic.name, topic.msgtype)
            for channel, topic in self._channels.items()
            if names is None or topic.name in names
        }
        for entries in self._batches(wanted.keys(), start_ns, stop_ns):
            for log_ns, _, channel, data in entries:
                name, msgtype = wanted[channel]
                yield BagMessage(name, msgtype, log_ns, data)

    def _find_messages(self, size: int) -> McapIndex:
        try:
            return index_from_summary(self._file, size)
        except SummaryError as error:
            if error.is_damage:
                self._note(str(error) if size else "it is empty")
            return McapScan(self._file, size, self._note).index()

    def _batches(self, wanted: Set[int], start_ns: int, stop_ns: int) -> Iterator[list[_Entry]]:
        """Yield entries in order, as soon as no later segment can come before them."""
        waiting: list[_Entry] = []
        for segment in self._segments:
            if segment.start_ns >= stop_ns:
                break
            channels = segment.channels
            if segment.end_ns < start_ns or (channels and channels.isdisjoint(wanted)):
                continue
            final = bisect_left(waiting, (segment.start_ns,))
            yield waiting[:final]
            entries = [
                each
                for each in self._load(segment).messages
                if each[2] in wanted and start_ns <= each[0] < stop_ns
            ]
            waiting = waiting[final:] + entries
            waiting.sort()
        yield waiting

    def _load(self, segment: Segment) -> Records:
        """Return what is whole in a segment."""
        if self._file.closed:
            raise BagError(f"{self._file.name!r} was closed while it was being read")
        try:
            data = read_at(self._file, segment.offset, segment.length)
            if segment.is_chunk:
                if not data.startswith(HEAD.pack(Opcode.CHUNK, segment.length - HEAD.size)):
                    raise ValueError("no chunk there")
                data = chunk_data(data[HEAD.size :])
            run = split_records(data, segment.offset << _ORDER_BITS)
            problem = "" if run.is_whole else "ends within a record"
        except DAMAGE as error:
            run, problem = Records([], [], is_whole=False), f"is damaged and skipped ({error})"
        if run.messages and min(run.messages)[0] < segment.start_ns:
            problem = "also holds earlier messages: messages may come out of order"
        if problem:
            self._note(
                f"the chunk at byte {segment.offset}, log times {segment.start_ns} to "
                f"{segment.end_ns} ns, {problem}"
            )
        return run

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
