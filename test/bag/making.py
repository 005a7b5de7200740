# SPDX-License-Identifier: Apache-2.0
"""Bags as tests want them, by our writer and by the libraries that others use."""

from __future__ import annotations

import contextlib
import io
import struct
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import zstandard
from mcap.exceptions import McapError
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, IndexType
from mcap.writer import Writer as LibraryMcapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from fuzzy_fusion_ros.bag import BagMessage, BagWriter

POINT = "geometry_msgs/msg/PointStamped"
FLOAT = "std_msgs/msg/Float64"
BEGIN_NS = 1_700_000_000_000_000_000
STEP_NS = 10_000_000
STORE = get_typestore(Stores.ROS2_JAZZY)


def definition_text(msgtype: str) -> str:
    """Return the definition of one of Jazzy's types with its nested types."""
    return STORE.generate_msgdef(msgtype, ros_version=2)[0]


def decoded(message: BagMessage) -> Any:
    """Return a message of one of Jazzy's types as rosbags reads it.

    Bytes after the message are ignored: rclpy leaves some where an array is empty, and rosbags
    refuses such messages as a whole.
    """
    kind = STORE.get_msgdef(message.msgtype)
    read = kind.deserialize_cdr_le if message.data[1] else kind.deserialize_cdr_be
    return read(message.data[4:], 0, kind.cls, STORE)[0]


def point_data(stamp_ns: int, value: float) -> bytes:
    """Return a serialised PointStamped, spelt out here once more."""
    return struct.pack(
        "<4siIIxxxx3d", b"\0\1\0\0", *divmod(stamp_ns, 1_000_000_000), 1, value, 0.0, 0.0
    )


def float_data(value: float) -> bytes:
    """Return a serialised Float64."""
    return struct.pack("<4sd", b"\0\1\0\0", value)


def points(count: int, topics: Sequence[str] = ("/s1",)) -> list[BagMessage]:
    """Return messages 10 ms apart, of the topics in turn."""
    return [
        BagMessage(
            topics[at % len(topics)],
            POINT,
            BEGIN_NS + at * STEP_NS,
            point_data(BEGIN_NS + at * STEP_NS, 0.5 + at),
        )
        for at in range(count)
    ]


def write_bag(path: Path, messages: Iterable[BagMessage]) -> Path:
    """Write a bag by the writer under test; return its storage file."""
    with BagWriter(path) as writer:
        for message in messages:
            writer.write(*message)
    return path / f"{path.name}_0.mcap"


def write_by_rosbags(
    path: Path,
    messages: Iterable[BagMessage],
    storage: StoragePlugin = StoragePlugin.MCAP,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write a bag by rosbags; return its storage file."""
    writer = RosbagsWriter(path, version=9, storage_plugin=storage)
    writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections = {}
        for message in messages:
            if message.topic not in connections:
                connections[message.topic] = writer.add_connection(
                    message.topic, message.msgtype, typestore=STORE
                )
            writer.write(connections[message.topic], message.log_ns, message.data)
    return next(each for each in path.iterdir() if each.name != "metadata.yaml")


class McapOptions(NamedTuple):
    """How mcap's writer is to write."""

    chunk_size: int = 1024
    compression: CompressionType = CompressionType.ZSTD
    use_chunking: bool = True
    use_statistics: bool = True
    use_summary_offsets: bool = True
    repeat_channels: bool = True
    repeat_schemas: bool = True
    index_types: IndexType = IndexType.ALL
    enable_crcs: bool = True


def write_by_mcap(
    path: Path, messages: Iterable[BagMessage], options: McapOptions | None = None
) -> Path:
    """Write a bare MCAP file by mcap's writer; return it."""
    with path.open("wb") as file:
        writer = LibraryMcapWriter(file, **(options or McapOptions())._asdict())
        writer.start("ros2", "test")
        schemas: dict[str, int] = {}
        channels: dict[str, int] = {}
        for message in messages:
            if message.msgtype not in schemas:
                schemas[message.msgtype] = writer.register_schema(
                    message.msgtype, "ros2msg", definition_text(message.msgtype).encode()
                )
            if message.topic not in channels:
                channels[message.topic] = writer.register_channel(
                    message.topic, "cdr", schemas[message.msgtype]
                )
            writer.add_message(
                channels[message.topic], message.log_ns, message.data, message.log_ns
            )
        writer.finish()
    return path


def chunk_ends(data: bytes) -> list[int]:
    """Return where the chunks of an MCAP file end, found by walking its records."""
    ends, position = [], 8
    while position + 9 <= len(data) - 8:
        opcode, length = struct.unpack_from("<BQ", data, position)
        position += 9 + length
        if opcode == 6:
            ends.append(position)
    return ends


def salvage_by_mcap(data: bytes) -> list[bytes]:
    """Return the messages that mcap's own reader finds before it gives up."""
    found = []
    with contextlib.suppress(McapError, struct.error, zstandard.ZstdError):  # all that a cut gives
        for record in StreamReader(io.BytesIO(data), validate_crcs=True).records:
            if isinstance(record, Message):
                found.append(record.data)
    return found


class Channel(NamedTuple):
    """A channel of an MCAP file as any program may write it.

    Attributes:
        topic: The topic.
        messages: Log time, ns, and bytes of each message.
        encoding: How the messages are said to be serialised.
        msgtype: The name of the schema; None for no schema.
        schema: How the schema is encoded.
        text: The schema.
        metadata: What the channel says besides.
    """

    topic: str
    messages: Sequence[tuple[int, bytes]]
    encoding: str = "cdr"
    msgtype: str | None = POINT
    schema: str = "ros2msg"
    text: str = definition_text(POINT)
    metadata: Mapping[str, str] = MappingProxyType({})


def write_channels(path: Path, channels: Iterable[Channel], profile: str = "ros2") -> Path:
    """Write a bare MCAP file of any channels by mcap's writer; return it."""
    with path.open("wb") as file:
        writer = LibraryMcapWriter(file)
        writer.start(profile, "test")
        rows = []
        for each in channels:
            schema = 0
            if each.msgtype is not None:
                schema = writer.register_schema(each.msgtype, each.schema, each.text.encode())
            number = writer.register_channel(each.topic, each.encoding, schema, dict(each.metadata))
            rows += [(log_ns, number, data) for log_ns, data in each.messages]
        for log_ns, number, data in sorted(rows):
            writer.add_message(number, log_ns, data, log_ns)
        writer.finish()
    return path
