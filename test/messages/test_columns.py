# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers: the same as those read message by message."""

from __future__ import annotations

import math
import random
import struct

import numpy as np
import pytest
from messages.worlds import World

from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.columns import ColumnReader, Columns
from fuzzy_fusion_ros.parameters.errors import MessageError

JOINT_STATE = "sensor_msgs/msg/JointState"
POINT = "geometry_msgs/msg/PointStamped"


def one_by_one(codecs: list[ScalarCodec], messages: list[tuple[bytes, int]]) -> Columns:
    """Return what the codecs read of each message."""
    n = len(messages)
    stamps = np.array([received_ns for _, received_ns in messages], np.int64)
    values = np.full((len(codecs), n), math.nan)
    lacking = np.ones((len(codecs), n), np.bool_)
    for k, codec in enumerate(codecs):
        for place, (data, received_ns) in enumerate(messages):
            try:
                sample = codec.sample(data, received_ns)
            except MessageError:
                continue
            stamps[place], values[k, place] = sample.stamp_ns, sample.value
            lacking[k, place] = False
    received = np.array([received_ns for _, received_ns in messages], np.int64)
    return Columns(stamps, np.zeros(n, np.bool_), received, values, lacking)


def add(reader: ColumnReader, messages: list[tuple[bytes, int]]) -> None:
    """Give a reader messages and their times of receipt, one behind the other in a buffer."""
    sizes = np.array([len(data) for data, _ in messages], np.int64)
    received = np.array([received_ns for _, received_ns in messages], np.int64)
    data = b"".join(data for data, _ in messages)
    reader.add(data, np.cumsum(sizes) - sizes, sizes, received)


def require_equal(found: Columns, expected: Columns) -> None:
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(one, other)


def joints(world: World, generator: random.Random, sizes: int) -> bytes:
    """Make a JointState whose texts and arrays are of a few lengths."""
    size = generator.randrange(sizes)
    values = {
        "header.stamp.sec": generator.randrange(2**31),
        "header.stamp.nanosec": generator.randrange(10**9),
        "header.frame_id": generator.choice(["", "base", "a longer frame"]),
        "name": [generator.choice(["cart", "pole", "arm"]) for _ in range(size)],
        "position": [generator.uniform(-9.0, 9.0) for _ in range(size)],
        "velocity": [generator.uniform(-9.0, 9.0) for _ in range(generator.randrange(sizes))],
    }
    return world.data(JOINT_STATE, values)


@pytest.mark.parametrize(
    "fields",
    [
        ["position[0]"],
        ["position[0]", "position[2]", "velocity[1]", "effort[0]"],
        ["name=pole:position"],
        ["name=pole:position", "velocity[0]"],
    ],
)
@pytest.mark.parametrize("sizes", [3, 9])
def test_columns_are_what_each_message_holds(world: World, fields: list[str], sizes: int) -> None:
    generator = random.Random(sizes)
    codecs = [ScalarCodec(world.types, JOINT_STATE, field) for field in fields]
    messages = [(joints(world, generator, sizes), 100 + k) for k in range(300)]
    messages[20] = (b"\0\1\0\0no message at all", 120)
    messages[21] = (b"", 121)
    reader = ColumnReader(codecs)
    for k in range(0, 300, 64):  # several blocks, the last one not full
        add(reader, messages[k : k + 64])
    require_equal(reader.columns(), one_by_one(codecs, messages))


def test_every_number_in_either_byte_order(rosbags: World) -> None:
    values = {
        "tiny": -5,
        "small": 200,
        "wide": -(2**40),
        "widest": 2**50,
        "single": 1.5,
        "fixed": [1.0, 2.0, 3.0],
        "whole": [-7, 8],
        "yes": True,
    }
    fields = ["tiny", "small", "wide", "widest", "single", "fixed[1]", "whole[1]"]
    codecs = [ScalarCodec(rosbags.types, "test_msgs/msg/Numbers", field) for field in fields]
    data = rosbags.data("test_msgs/msg/Numbers", values)
    reader = ColumnReader(codecs)
    add(reader, [(data, received_ns) for received_ns in range(3)])
    found = reader.columns()
    assert found.values[:, 2].tolist() == [-5.0, 200.0, -(2.0**40), 2.0**50, 1.5, 2.0, 8.0]
    assert found.stamps_ns.tolist() == [0, 1, 2]  # it has no stamp
    big = b"\0\0\0\0" + struct.pack(">iIIxxxx3d", 7, 8, 1, 2.5, 0.0, 0.0)
    point = ColumnReader([ScalarCodec(rosbags.types, POINT)])
    add(point, [(big, 0)])
    found = point.columns()
    assert found.values.tolist() == [[2.5]]
    assert found.stamps_ns.tolist() == [7_000_000_008]
    assert point.columns().values.size == 0


@pytest.mark.parametrize("first", [0, 1])
def test_nanoseconds_of_a_second_or_more_are_marked(world: World, first: int) -> None:
    reader = ColumnReader([ScalarCodec(world.types, POINT)])
    for k in range(4):
        nanoseconds = 2_000_000_000 if k % 2 == first else 5
        stamp = {"header.stamp.sec": k, "header.stamp.nanosec": nanoseconds}
        add(reader, [(world.data(POINT, stamp | {"point.x": float(k)}), 0)])
    found = reader.columns()
    assert found.overflows.tolist() == [k % 2 == first for k in range(4)]
    assert found.values.tolist() == [[0.0, 1.0, 2.0, 3.0]]


def test_a_message_of_the_wrong_size_is_no_layout_whatever_its_stamp(world: World) -> None:
    reader = ColumnReader([ScalarCodec(world.types, POINT)])
    for nanoseconds in (2_000_000_000, 5, 5):
        stamp = {"header.stamp.sec": 1, "header.stamp.nanosec": nanoseconds}
        add(reader, [(world.data(POINT, stamp) + bytes(100), 0)])
    found = reader.columns()
    assert found.lacking.tolist() == [[True, True, True]]
    assert found.overflows.tolist() == [False, False, False]


def test_nanoseconds_are_marked_where_a_name_is_looked_up(world: World) -> None:
    reader = ColumnReader([ScalarCodec(world.types, JOINT_STATE, "name=pole:position")])
    joint = {"name": ["pole"], "position": [1.0]}
    add(reader, [(world.data(JOINT_STATE, joint | {"header.stamp.nanosec": 10**9}), 0)])
    found = reader.columns()
    assert found.overflows.tolist() == [True]
    assert found.lacking.tolist() == [[False]]


def test_no_message_at_all(world: World) -> None:
    found = ColumnReader([ScalarCodec(world.types, POINT)]).columns()
    assert found.values.shape == (1, 0)
    assert found.stamps_ns.size == 0
