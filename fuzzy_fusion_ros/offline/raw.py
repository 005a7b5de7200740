# SPDX-License-Identifier: Apache-2.0
"""The samples of topics as arrays, as they were recorded: nothing is dropped or put in order."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.columns import ColumnReader, Columns
from fuzzy_fusion_ros.offline.tracks import Progress


class Source(NamedTuple):
    """Where samples are.

    Attributes:
        topic: The topic.
        codec: Reads its messages.
    """

    topic: str
    codec: ScalarCodec


class RawSamples(NamedTuple):
    """The samples of one source.

    Attributes:
        stamps_ns: Their stamps, log times where messages have none, shape (n,), nanoseconds.
        overflows: Whether the nanoseconds of a stamp are a second or more, shape (n,).
        log_ns: When they were recorded, shape (n,), nanoseconds.
        values: What was measured, whatever it is, shape (n,).
        unreadable: Messages that hold no such number.
    """

    stamps_ns: Stamps
    overflows: Flags
    log_ns: Stamps
    values: Reals
    unreadable: int


def read_raw(
    bag: BagReader,
    sources: Mapping[str, Source],
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
    every: Mapping[str, int] | None = None,
) -> dict[str, RawSamples]:
    """Read all samples of some sources in one pass.

    Args:
        bag: The bag, which has their topics.
        sources: The sources by names of your own.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.
        every: By topic, n if only every n-th message is to be read.
    """
    names: dict[str, list[str]] = {}
    for name, source in sources.items():
        names.setdefault(source.topic, []).append(name)
    readers = {
        topic: ColumnReader([sources[name].codec for name in named])
        for topic, named in names.items()
    }
    strides = every or {}
    seen: Counter[str] = Counter()
    for block in progress(bag.blocks(list(readers), start_s, end_s)):
        for topic, reader in readers.items():
            found = block.on(topic)
            count, stride = found.at.size, strides.get(topic, 1)
            chosen = found.chosen(slice(-seen[topic] % stride, None, stride))
            reader.add(chosen.data, chosen.at, chosen.sizes, chosen.log_ns)
            seen[topic] += count
    return {
        name: _samples(columns, k)
        for topic, reader in readers.items()
        for columns in [reader.columns()]
        for k, name in enumerate(names[topic])
    }


def _samples(columns: Columns, k: int) -> RawSamples:
    """Return one of the columns; whole ones share their stamps."""
    there = ~columns.lacking[k]
    count = int(np.count_nonzero(there))
    kept = slice(None) if count == there.size else there
    return RawSamples(
        columns.stamps_ns[kept],
        columns.overflows[kept],
        columns.received_ns[kept],
        columns.values[k, kept],
        there.size - count,
    )
