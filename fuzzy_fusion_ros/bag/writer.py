# SPDX-License-Identifier: Apache-2.0
"""Writes rosbag2 directories."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from rosbags.interfaces import Qos

from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.bag.mcap.writer import McapWriter
from fuzzy_fusion_ros.bag.metadata import describe_bag, qos_to_text, write_metadata
from fuzzy_fusion_ros.bag.topic import MSG_ENCODINGS, UNDESCRIBED, Definition, Topic
from fuzzy_fusion_ros.bag.typestore import BagTypes, jazzy_types
from fuzzy_fusion_ros.parameters.errors import BagError


class BagWriter:
    """A new rosbag2 directory with one MCAP file, as rosbag2 of Jazzy writes it.

    A context manager. ``metadata.yaml`` exists from the start and is rewritten whenever the bag
    has doubled, so that a bag whose recorder was killed opens too. The same messages give the
    same bytes. If a write is interrupted (Ctrl-C), :meth:`close` still completes the bag.
    """

    def __init__(self, path: str | Path, types: BagTypes | None = None) -> None:
        """Create the bag.

        Args:
            path: The directory; it must be empty or not exist.
            types: Source of definitions that :meth:`add_topic` is not given; Jazzy's and the
                installed types unless given.

        Raises:
            BagError: The directory holds something or cannot be written.
        """
        self.path = Path(path)
        self._types = types or jazzy_types()
        self._topics: dict[int, Topic] = {}  # by the ids of their channels
        self._channels: dict[tuple[str, str], int] = {}  # by topic and type
        self._schemas: dict[tuple[str, Definition], int] = {}
        self._described_chunks = 0
        self._failure: OSError | None = None
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            if any(self.path.iterdir()):
                raise BagError(f"bag {str(path)!r} exists: choose another directory or remove it")
            name = os.fsencode(self.path.resolve().name).decode(errors="replace")
            self._file_name = f"{name}_0.mcap"
            self._file = McapWriter(self.path / os.fsdecode(self._file_name.encode()))
        except (OSError, ValueError) as error:
            raise BagError(_refused(self.path, error)) from error
        try:
            self._write_metadata()
        except OSError as error:
            self._file.close()
            raise BagError(_refused(self.path, error)) from error

    def __enter__(self) -> BagWriter:
        """Return the writer itself."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the bag, also after an error: what was written is whole."""
        self.close()

    @property
    def span_ns(self) -> tuple[int, int]:
        """The earliest and the latest log time on disk; zeros before the first chunk."""
        return self._file.span_ns

    def add_topic(
        self,
        topic: str,
        msgtype: str,
        *,
        qos: Iterable[Qos] = (),
        definition: Definition | None = None,
        encoding: str = "cdr",
    ) -> None:
        """Declare a topic of a type before its first message; do nothing if it is declared.

        Args:
            topic: Its name, such as ``/s1``.
            msgtype: ``package/msg/Type``.
            qos: The profiles that it is offered with.
            definition: The definition of the type, as a reader returns it; looked up unless
                given.
            encoding: How the messages are serialised.

        Raises:
            BagError: The type has no definition, or the name is no UTF-8.
        """
        _require_text(topic)
        if (topic, msgtype) in self._channels:
            return
        definition = definition or self._types.definition(msgtype)
        if not definition.text and definition.encoding not in MSG_ENCODINGS:
            definition = UNDESCRIBED
        profiles = tuple(qos)
        schema = self._schemas.get((msgtype, definition))
        if schema is None:
            schema = self._file.add_schema(msgtype, definition.encoding, definition.text)
            self._schemas[msgtype, definition] = schema
        metadata = {
            "offered_qos_profiles": qos_to_text(profiles),
            "topic_type_hash": definition.digest,
        }
        channel = self._file.add_channel(topic, encoding, schema, metadata)
        self._channels[topic, msgtype] = channel
        self._topics[channel] = Topic(topic, msgtype, 0, definition, profiles, encoding)

    def write(self, topic: str, msgtype: str, log_ns: int, data: bytes) -> None:
        """Write a message.

        Args:
            topic: Declared before, else declared now without QoS.
            msgtype: ``package/msg/Type``, that of the topic.
            log_ns: When it was received, ns since the epoch, not negative.
            data: CDR with its encapsulation header.

        Raises:
            BagError: The bag is closed or cannot be written, the type has no definition, or the
                time does not fit.
        """
        self._require_open()
        channel = self._channels.get((topic, msgtype))
        if channel is None:
            channel = self._channel(topic, msgtype)
        if not 0 <= log_ns < 2**63:
            raise BagError(f"log time {log_ns!r} ns is out of range: expected 0 to 2^63 - 1")
        try:
            if self._file.write(channel, log_ns, data):
                self._keep_metadata_up()
        except OSError as error:
            self._failure = error
            raise self._refusal(error) from error

    def write_block(self, block: Block) -> None:
        """Write messages that lie side by side, as :meth:`write` does one by one.

        Args:
            block: The messages, log times not negative.

        Raises:
            BagError: The bag is closed or cannot be written, or a type has no definition.
        """
        self._require_open()
        used = np.bincount(block.kinds, minlength=len(block.names))
        channels = [
            self._channel(*name) if count else 0
            for name, count in zip(block.names, used, strict=True)
        ]
        try:
            if self._file.write_block(block, np.array(channels, np.uint16)[block.kinds]):
                self._keep_metadata_up()
        except OSError as error:
            self._failure = error
            raise self._refusal(error) from error

    def close(self) -> None:
        """Write what is pending, the index and the metadata; the second call does nothing.

        Raises:
            BagError: They cannot be written, and no write has said so; what was written before
                stays readable.
        """
        if self._file.is_closed():
            return
        try:
            self._file.flush()
            self._file.finish(self._description())
            self._write_metadata()
        except OSError as error:
            if self._failure is None:
                raise self._refusal(error) from error
        finally:
            self._file.close()

    def _require_open(self) -> None:
        if self._file.is_closed():
            raise BagError(f"bag {str(self.path)!r} is closed: nothing can be written to it")
        if self._failure is not None:
            raise self._refusal(self._failure)

    def _channel(self, topic: str, msgtype: str) -> int:
        """Return the channel of a topic, declared now if it was not."""
        self.add_topic(topic, msgtype)
        return self._channels[topic, msgtype]

    def _keep_metadata_up(self) -> None:
        """Rewrite the metadata if the bag has doubled since."""
        if self._file.chunk_count >= 2 * self._described_chunks:
            self._write_metadata()

    def _write_metadata(self) -> None:
        write_metadata(self.path, self._description())
        self._described_chunks = self._file.chunk_count

    def _description(self) -> str:
        counts = self._file.counts
        topics = [
            topic._replace(message_count=counts[channel]) for channel, topic in self._topics.items()
        ]
        return describe_bag(self._file_name, topics, *self._file.span_ns)

    def _refusal(self, error: Exception) -> BagError:
        kept = "; what was written before stays readable" if self._file.chunk_count else ""
        return BagError(_refused(self.path, error) + kept)


def _refused(path: Path, error: Exception) -> str:
    return f"bag {str(path)!r} cannot be written: {getattr(error, 'strerror', error)}"


def _require_text(topic: str) -> None:
    try:
        topic.encode()
    except UnicodeEncodeError:
        raise BagError(f"topic {topic!r} is not valid UTF-8: choose another name") from None
