# SPDX-License-Identifier: Apache-2.0
"""Samples of a bag as arrays, before any filter."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from bag.making import FLOAT, POINT, float_data, point_data
from bag.recorded import BEGIN_NS, Scalar, at, swing, write_scalars

from fuzzy_fusion_ros.bag import BagWriter, open_bag
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.offline.raw import RawSamples, Source, read_raw


def read(path: Path, *topics: str, **options: float) -> dict[str, RawSamples]:
    """Read the default numbers of some topics."""
    with open_bag(path) as bag:
        sources = {
            topic: Source(topic, ScalarCodec(bag.types, bag.topics[topic].msgtype))
            for topic in topics
        }
        return read_raw(bag, sources, **options)


def test_nothing_is_dropped_or_put_in_order(tmp_path: Path) -> None:
    scalars = [
        Scalar("/s1", 2.0, math.nan, log_s=0.0),
        Scalar("/s1", 1.0, 1.0, log_s=0.1),
        Scalar("/s2", 0.0, 9.0, log_s=0.2),
        Scalar("/s1", 1.0, math.inf, log_s=0.3),
        Scalar("/s1", -BEGIN_NS * 1e-9 - 1.0, 2.0, log_s=0.4),
    ]
    found = read(write_scalars(tmp_path / "bag", scalars), "/s1", "/s2")
    s1 = found["/s1"]
    assert s1.stamps_ns[:3].tolist() == [at(2.0), at(1.0), at(1.0)]
    assert s1.stamps_ns[3] < 0
    assert s1.log_ns.tolist() == [at(0.0), at(0.1), at(0.3), at(0.4)]
    np.testing.assert_array_equal(s1.values, [math.nan, 1.0, math.inf, 2.0])
    assert found["/s2"].values.tolist() == [9.0]
    assert s1.unreadable == 0


def test_the_log_time_stands_in_for_a_stamp(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        writer.write("/s1", FLOAT, at(3.0), float_data(1.5))
    samples = read(tmp_path / "bag", "/s1")["/s1"]
    assert samples.stamps_ns.tolist() == samples.log_ns.tolist() == [at(3.0)]


def test_unreadable_messages_are_counted(tmp_path: Path) -> None:
    with BagWriter(tmp_path / "bag") as writer:
        writer.write("/s1", POINT, at(0.0), point_data(at(0.0), 1.0))
        writer.write("/s1", POINT, at(0.1), b"\0\1\0\0short")
    samples = read(tmp_path / "bag", "/s1")["/s1"]
    assert (samples.values.tolist(), samples.unreadable) == ([1.0], 1)


def test_a_span_and_every_so_many(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(2.0))
    with open_bag(path) as bag:
        sources = {"s1": Source("/s1", ScalarCodec(bag.types, POINT))}
        samples = read_raw(bag, sources, 0.5, 1.5, every={"/s1": 10})["s1"]
    assert samples.log_ns.tolist() == [at(0.5 + 0.1 * k) for k in range(10)]
