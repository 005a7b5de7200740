# SPDX-License-Identifier: Apache-2.0
"""Our parts for bags and messages against the libraries that they stand in for."""

from __future__ import annotations

import shutil
import struct
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import backports.zstd
import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader
from mcap.writer import Writer as McapLibraryWriter
from rclpy.serialization import deserialize_message
from rosbags.highlevel import AnyReader
from rosbags.interfaces import Connection
from rosbags.rosbag2 import ReaderError, StoragePlugin
from rosbags.rosbag2 import Writer as RosbagsWriter
from rosbags.typesys import Stores, get_typestore

from bench.big_bag import JOINTS, RECORDING, write_bag
from bench.effort import Effort
from bench.measuring import compared, cpu_seconds, interleaved
from bench.table import Row
from fuzzy_fusion_ros.bag import BagMessage, BagWriter, jazzy_types, open_bag
from fuzzy_fusion_ros.messages import ScalarCodec, default_message, load_message_class
from fuzzy_fusion_ros.messages.outputs import POINT

STORE = get_typestore(Stores.ROS2_JAZZY)
GIVING_UP: tuple[type[Exception], ...] = (
    McapError,
    ReaderError,
    backports.zstd.ZstdError,
    zstandard.ZstdError,
    OverflowError,
    LookupError,
    ValueError,
    struct.error,
)
"""What the libraries raise at the first damaged byte."""

FIELDS: dict[str, tuple[str, Callable[[Any], float]]] = {
    POINT: ("point.x", lambda message: float(message.point.x)),
    "sensor_msgs/msg/Imu": (
        "linear_acceleration.x",
        lambda message: float(message.linear_acceleration.x),
    ),
    JOINTS: ("position[0]", lambda message: float(message.position[0])),
}


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time per message, and what one damaged byte costs."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_bag(folder / "bag", effort.messages // 10, RECORDING)
        return [*_reading(folder, effort), *_writing(folder, effort), *_codec(effort)]


def _reading(folder: Path, effort: Effort) -> list[Row]:
    path = folder / "bag" / "bag_0.mcap"
    found = _rows(
        effort,
        effort.messages // 10,
        "read a message, raw",
        lambda: count(read(path)),
        {
            "rosbags": lambda: count(read_by_rosbags(path.parent)),
            "mcap, by its index": lambda: count(read_by_mcap(path)),
            "mcap, as a stream": lambda: count(stream_by_mcap(path)),
        },
    )
    flip_a_byte(path)
    ours = count(read(path))
    for name, messages in (
        ("rosbags", read_by_rosbags(path.parent)),
        ("mcap, by its index", read_by_mcap(path)),
        ("mcap, as a stream", stream_by_mcap(path)),
    ):
        theirs = count(messages)
        what = f"messages of {effort.messages // 10:,} read after one byte in the middle is flipped"
        found.append(Row(what, f"{ours:,}", f"{theirs:,} {name}", ours / max(theirs, 1)))
    return found


def _writing(folder: Path, effort: Effort) -> list[Row]:
    with open_bag(folder / "bag") as bag:
        messages = list(bag.messages())

    def fresh() -> Path:
        shutil.rmtree(folder / "new", ignore_errors=True)
        return folder / "new"

    return _rows(
        effort,
        len(messages),
        "write a message",
        lambda: write(fresh(), messages),
        {
            "rosbags": lambda: write_by_rosbags(fresh(), messages),
            "mcap": lambda: write_by_mcap(fresh(), messages),
        },
    )


def _codec(effort: Effort) -> list[Row]:
    found = []
    times = effort.messages // 20
    for msgtype, (field, get) in FIELDS.items():
        codec = ScalarCodec(jazzy_types(), msgtype, field)
        cls = load_message_class(msgtype)
        data = message_with_number(msgtype)
        work = (
            lambda codec=codec, data=data: codec.sample(data, 0),
            lambda msgtype=msgtype, get=get, data=data: get(STORE.deserialize_cdr(data, msgtype)),
            lambda cls=cls, get=get, data=data: get(deserialize_message(data, cls)),
        )
        ours, rosbags, rclpy = (lambda each=each: repeat(each, times) for each in work)
        what = f"stamp and number of a {msgtype.rpartition('/')[2]}"
        found += _rows(effort, times, what, ours, {"rosbags": rosbags, "rclpy": rclpy})
    return found


def _rows(
    effort: Effort,
    count_: int,
    what: str,
    ours: Callable[[], object],
    theirs: dict[str, Callable[[], object]],
) -> list[Row]:
    """Return CPU time per message beside that of others."""
    measures = [
        lambda each=each: 1e6 * cpu_seconds(each) / count_ for each in (ours, *theirs.values())
    ]
    own, *others = interleaved(effort.repetitions, *measures)
    found = []
    for name, values in zip(theirs, others, strict=True):
        it = compared(own, values)
        found.append(
            Row(f"{what}, CPU", f"{it.ours:.1f} µs", f"{it.against:.1f} µs {name}", it.ratio)
        )
    return found


def repeat(work: Callable[[], object], times: int) -> None:
    """Do something again and again."""
    for _ in range(times):
        work()


def count(messages: Iterable[object]) -> int:
    """Count what can be read before the reader gives up."""
    number = 0
    try:
        for _ in messages:
            number += 1
    except GIVING_UP:
        pass
    return number


def flip_a_byte(path: Path) -> None:
    """Flip a byte in the middle of a file."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)


def read(path: Path) -> Iterable[object]:
    """Yield messages as this package reads them."""
    with open_bag(path) as bag:
        yield from bag.messages()


def read_by_rosbags(path: Path) -> Iterable[object]:
    """Yield messages as rosbags' documentation reads them."""
    with AnyReader([path]) as reader:
        yield from reader.messages()


def read_by_mcap(path: Path) -> Iterable[object]:
    """Yield messages as mcap's documentation reads them."""
    with path.open("rb") as file:
        yield from make_reader(file, validate_crcs=True).iter_messages()


def stream_by_mcap(path: Path) -> Iterable[object]:
    """Yield messages as they stand in the file, as mcap recovers damaged ones."""
    with path.open("rb") as file:
        for record in StreamReader(file, validate_crcs=True).records:
            if isinstance(record, Message):
                yield record


def write(path: Path, messages: Iterable[BagMessage]) -> None:
    """Write a bag with this package."""
    with BagWriter(path) as writer:
        for each in messages:
            writer.write(*each)


def write_by_rosbags(path: Path, messages: Iterable[BagMessage]) -> None:
    """Write a bag with rosbags."""
    with RosbagsWriter(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connections: dict[str, Connection] = {}
        for each in messages:
            if each.topic not in connections:
                connections[each.topic] = writer.add_connection(
                    each.topic, each.msgtype, typestore=STORE
                )
            writer.write(connections[each.topic], each.log_ns, each.data)


def write_by_mcap(path: Path, messages: Iterable[BagMessage]) -> None:
    """Write an MCAP file with mcap's writer."""
    path.mkdir()
    with (path / "new.mcap").open("wb") as file:
        writer = McapLibraryWriter(file)
        writer.start("ros2")
        channels: dict[str, int] = {}
        for each in messages:
            if each.topic not in channels:
                text = STORE.generate_msgdef(each.msgtype, ros_version=2)[0]
                schema = writer.register_schema(each.msgtype, "ros2msg", text.encode())
                channels[each.topic] = writer.register_channel(each.topic, "cdr", schema)
            writer.add_message(channels[each.topic], each.log_ns, each.data, each.log_ns)
        writer.finish()


def message_with_number(msgtype: str) -> bytes:
    """Return a serialised message that holds the number."""
    if msgtype != JOINTS:
        return default_message(jazzy_types(), msgtype)
    kind = STORE.types
    joints = kind[JOINTS](
        header=kind["std_msgs/msg/Header"](
            stamp=kind["builtin_interfaces/msg/Time"](sec=1, nanosec=2), frame_id=""
        ),
        name=["cart", "pole"],
        **dict.fromkeys(("position", "velocity", "effort"), np.array([0.5, 1.0])),
    )
    return bytes(STORE.serialize_cdr(joints, JOINTS))
