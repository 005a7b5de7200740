# SPDX-License-Identifier: Apache-2.0
"""Reads bags: rosbag2 directories and single storage files, intact or damaged."""

from __future__ import annotations

import heapq
import itertools
import math
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack
from functools import cached_property, partial
from operator import attrgetter
from pathlib import Path

import zstandard

from fuzzy_fusion_ros.bag.block import Block, gathered
from fuzzy_fusion_ros.bag.compression import decompress
from fuzzy_fusion_ros.bag.metadata import METADATA_NAME
from fuzzy_fusion_ros.bag.problems import Problems
from fuzzy_fusion_ros.bag.storage import Storage, find_files, is_compressed, open_file
from fuzzy_fusion_ros.bag.topic import BagMessage, Topic
from fuzzy_fusion_ros.bag.typestore import BagTypes
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.parameters.errors import BagError

_FOREVER_NS = 2**63 - 1

_OTHER_CDR = {
    **dict.fromkeys((b"\0\2", b"\0\3"), "CDR parameter lists"),
    **{bytes([0, kind]): "XCDR2" for kind in range(6, 12)},
}
"""Encapsulations of DDS that ROS 2 does not use, by how messages begin."""


def open_bag(path: str | Path) -> BagReader:
    """Open a rosbag2 directory or a single ``.mcap`` file, intact or damaged.

    Raises:
        BagError: There is no such bag, or nothing in it can be read.
    """
    return BagReader(path)


class BagReader:
    """An open bag; a context manager.

    Memory does not grow with the bag: messages are read chunk by chunk. (It grows if log times are
    out of order between chunks.)

    Attributes:
        path: The bag.
        topics: The topics by their names.
        start_ns: The log time of the first message, ns; None without messages.
        end_ns: The log time of the last message, ns; None without messages.
    """

    def __init__(self, path: str | Path) -> None:
        """Open a bag.

        Args:
            path: A rosbag2 directory, or a storage file.

        Raises:
            BagError: There is no such bag, or nothing in it can be read.
        """
        self.path = Path(path)
        self._problems = Problems()
        self._obstacles: dict[str, str] = {}
        files, metadata = find_files(self.path, self._problems)
        self._is_message_compressed = bool(metadata and metadata.compression_mode == "message")
        with ExitStack() as opening:
            self._storages = self._open(files, opening)
            self._stack = opening.pop_all()
        self._described = [topic for each in self._storages for topic in each.topics]
        self.topics = _merge_topics(self._described, self._problems.note)
        starts = [each.start_ns for each in self._storages if each.start_ns is not None]
        ends = [each.end_ns for each in self._storages if each.end_ns is not None]
        self.start_ns = min(starts, default=None)
        self.end_ns = max(ends, default=None)
        if metadata and self.message_count not in {None, metadata.message_count}:
            self._problems.note(
                METADATA_NAME,
                f"it counts {metadata.message_count} messages, there are {self.message_count}",
            )

    def __enter__(self) -> BagReader:
        """Return the reader itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bag."""
        self.close()

    def close(self) -> None:
        """Close the bag; the second call does nothing."""
        self._stack.close()
        self._storages = []

    @property
    def problems(self) -> list[str]:
        """Problems of the bag, one line each; reading on can add some."""
        return [*self._problems.lines, *self.types.problems]

    @property
    def message_count(self) -> int | None:
        """Messages on all topics; None where the bag does not say."""
        return _total(topic.message_count for topic in self._described)

    @cached_property
    def types(self) -> BagTypes:
        """The message types, as the bag describes them."""
        return BagTypes(self._described)

    def name_of(self, topic: str) -> str:
        """Return a topic's name as the bag spells it, with or without the leading slash."""
        other = topic.removeprefix("/") if topic.startswith("/") else f"/{topic}"
        return other if topic not in self.topics and other in self.topics else topic

    def require_topics(self, *names: str) -> None:
        """Check that topics are in the bag.

        Raises:
            BagError: One is not; the error lists those that are.
        """
        missing = [name for name in names if name not in self.topics]
        if missing:
            there = ", ".join(f"{each.name} ({each.msgtype})" for each in self.topics.values())
            nothing = "; ".join(["no topics", *self._problems.lines])
            raise BagError(
                f"bag {str(self.path)!r} has no topic {', '.join(map(repr, missing))}; "
                f"it has {there or nothing}"
            )

    def require_readable(self, topic: str) -> None:
        """Check that numbers can be read from the messages of a topic.

        Args:
            topic: A topic in the bag, as the bag spells it.

        Raises:
            BagError: They are not plain CDR, of several types, or of a type that the bag does not
                describe.
        """
        if topic not in self._obstacles:
            self._obstacles[topic] = self.topics[topic].obstacle or self._foreign_cdr(topic)
        obstacle = self._obstacles[topic]
        if obstacle:
            raise BagError(f"bag {str(self.path)!r}, topic {topic}: {obstacle}")

    def _foreign_cdr(self, topic: str) -> str:
        """Say what kind of CDR the first message of a topic is, if it is not ROS 2's plain one."""
        first = next(self.messages([topic]), None)
        kind = _OTHER_CDR.get(first.data[:2]) if first else None
        return f"its messages are {kind}, only plain CDR (XCDR1) can be read" if kind else ""

    def require_messages_from(self, start_s: float | None) -> None:
        """Check that a span does not begin after the last message.

        Args:
            start_s: Where it begins, s from the bag's first message; None for there.

        Raises:
            BagError: It does; the error says where the last message is.
        """
        if start_s is None or self.start_ns is None or self.end_ns is None:
            return
        if self._limit_ns(start_s, 0) > self.end_ns:
            raise BagError(
                f"bag {str(self.path)!r} has no message from {start_s:g} s on: "
                f"its last is at {seconds_between(self.start_ns, self.end_ns):.3f} s"
            )

    def share(self, start_s: float | None, end_s: float | None) -> float:
        """Return how much of the bag's time a span covers, 0 to 1.

        Args:
            start_s: Where it begins, s from the bag's first message; None for there.
            end_s: Where it ends, s from the bag's first message; None for the last one.

        Raises:
            BagError: The bag is closed, or a limit is not finite.
        """
        _, start_ns, stop_ns = self._span(None, start_s, end_s)
        first_ns, last_ns = self.start_ns or 0, self.end_ns or 0
        covered_ns = min(stop_ns, last_ns) - max(start_ns, first_ns)
        return max(0, covered_ns) / (last_ns - first_ns) if last_ns > first_ns else 1.0

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_s: float | None = None,
        end_s: float | None = None,
    ) -> Iterator[BagMessage]:
        """Return the messages in the order of their log times, equal ones as they are stored.

        Damaged parts are left out and listed in :attr:`problems`.

        Args:
            topics: The topics to read; None for all.
            start_s: Where to begin, s from the bag's first message; None for there.
            end_s: Where to end, before this, s from the bag's first message; None for after
                the last one.

        Raises:
            BagError: The bag is closed, or a limit is not finite.
        """
        names, start_ns, stop_ns = self._span(topics, start_s, end_s)
        found = self._messages(names, start_ns, stop_ns)
        return self._decompress(found) if self._is_message_compressed else found

    def blocks(
        self,
        topics: Collection[str] | None = None,
        start_s: float | None = None,
        end_s: float | None = None,
    ) -> Iterator[Block]:
        """Return the same messages as :meth:`messages`, in blocks as chunks hold them."""
        names, start_ns, stop_ns = self._span(topics, start_s, end_s)
        files = self._filled()
        if self._is_message_compressed or not _follow_one_another(files):
            return gathered(self.messages(topics, start_s, end_s))
        return itertools.chain.from_iterable(
            each.blocks(names, start_ns, stop_ns) for each in files
        )

    def _span(
        self, topics: Collection[str] | None, start_s: float | None, end_s: float | None
    ) -> tuple[frozenset[str] | None, int, int]:
        """Return topics and log times as files take them."""
        if not self._storages:
            raise BagError(f"bag {str(self.path)!r} is closed: open it again to read it")
        names = None if topics is None else frozenset(topics)
        return names, self._limit_ns(start_s, 0), self._limit_ns(end_s, _FOREVER_NS)

    def _open(self, files: list[Path], opening: ExitStack) -> list[Storage]:
        """Open all files that can be; refuse if none can."""
        scratch = None
        if any(is_compressed(file) for file in files):
            scratch = Path(opening.enter_context(_temporary_directory()))
        storages: list[Storage] = []
        refusals: list[BagError] = []
        for file in files:
            try:
                storages.append(open_file(file, scratch, partial(self._problems.note, file.name)))
            except BagError as error:
                refusals.append(error)
                self._problems.note(file.name, str(error))
            else:
                opening.callback(storages[-1].close)
        if not storages:
            raise refusals[0]
        return storages

    def _limit_ns(self, seconds: float | None, otherwise_ns: int) -> int:
        if seconds is None:
            return otherwise_ns
        if not math.isfinite(seconds):
            raise BagError(
                f"span limit {seconds!r} s: expected finite seconds from the start of the bag"
            )
        offset_ns = round(max(-1e10, min(seconds, 1e10)) * 1e9)  # more than a clock can show
        return max(0, min((self.start_ns or 0) + offset_ns, _FOREVER_NS))

    def _filled(self) -> list[Storage]:
        """Return the files that may hold messages."""
        return [
            each
            for each in self._storages
            if _total(topic.message_count for topic in each.topics) != 0
        ]

    def _messages(
        self, names: frozenset[str] | None, start_ns: int, stop_ns: int
    ) -> Iterator[BagMessage]:
        """Chain the files if one begins where another ends, else merge them."""
        files = self._filled()
        found = [each.messages(names, start_ns, stop_ns) for each in files]
        if _follow_one_another(files):
            return itertools.chain.from_iterable(found)
        return heapq.merge(*found, key=attrgetter("log_ns"))

    def _decompress(self, messages: Iterable[BagMessage]) -> Iterator[BagMessage]:
        for message in messages:
            try:
                data = decompress("zstd", message.data)
            except (zstandard.ZstdError, ValueError) as error:
                self._problems.note(message.topic, f"messages do not decompress ({error})")
            else:
                yield message._replace(data=data)


def _follow_one_another(files: Sequence[Storage]) -> bool:
    """Return whether each file begins where the one before ends."""
    spans = [(each.start_ns, each.end_ns) for each in files]
    return all(
        end_ns is not None and start_ns is not None and end_ns <= start_ns
        for (_, end_ns), (start_ns, _) in itertools.pairwise(spans)
    )


def _merge_topics(found: Iterable[Topic], note: Callable[[str, str], None]) -> dict[str, Topic]:
    """Return the topics of several files by name, their messages added up."""
    topics: dict[str, Topic] = {}
    for topic in found:
        known = topics.setdefault(topic.name, topic)
        if known is topic:
            if topic.encoding != "cdr":
                note(topic.name, f"it is serialised as {topic.encoding!r}, not as 'cdr'")
            continue
        others = known.other_types
        if topic.msgtype not in (known.msgtype, *others):
            note(topic.name, f"it has messages of types {known.msgtype} and {topic.msgtype}")
            others = (*others, topic.msgtype)
        topics[topic.name] = known._replace(
            message_count=_total([known.message_count, topic.message_count]),
            definition=known.definition or topic.definition,
            qos=known.qos or topic.qos,
            other_types=others,
        )
    return dict(sorted(topics.items()))


def _total(counts: Iterable[int | None]) -> int | None:
    known = list(counts)
    return None if None in known else sum(count or 0 for count in known)


def _temporary_directory() -> tempfile.TemporaryDirectory[str]:
    try:
        return tempfile.TemporaryDirectory()
    except OSError as error:
        raise BagError(f"no temporary folder to decompress files in: {error.strerror}") from error
