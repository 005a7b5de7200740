# SPDX-License-Identifier: Apache-2.0
"""The numbers of many messages of one type, as arrays.

Messages in which all texts and arrays are as long have every number in the same place, and most
messages of a topic are such. They are put in rows, of which each number is a column.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages.codec import Place, ScalarCodec
from fuzzy_fusion_ros.messages.functions import PLAIN, Function
from fuzzy_fusion_ros.parameters.errors import MessageError, StampError

MOST_LAYOUTS = 16
"""Combinations of lengths of texts and arrays whose messages are put in rows."""

MOST_LENGTHS = 64
"""Messages with more texts and arrays are read one by one."""

BLOCK = 1 << 14
"""Messages that are kept as bytes before they are read."""


class Columns(NamedTuple):
    """Numbers of messages, in the order in which these were added.

    Attributes:
        stamps_ns: Stamps, times of receipt where messages have none, shape (n,), nanoseconds.
        overflows: Whether the nanoseconds of a stamp are a second or more, shape (n,).
        received_ns: Times of receipt, shape (n,), nanoseconds.
        values: The numbers, NaN where a message lacks one, shape (fields, n); where nanoseconds
            are wrong it may be NaN, too.
        lacking: Which ones a message lacks, shape (fields, n).
    """

    stamps_ns: NDArray[np.int64]
    overflows: NDArray[np.bool_]
    received_ns: NDArray[np.int64]
    values: NDArray[np.float64]
    lacking: NDArray[np.bool_]


class ColumnReader:
    """Reads some numbers of all messages that it is given."""

    def __init__(self, codecs: Sequence[ScalarCodec]) -> None:
        """Start.

        Args:
            codecs: Of the numbers, at least one, all of one type.
        """
        self._codecs = codecs
        self._looks_up = any(each.field.looks_up for each in codecs)
        self._rows: list[_Rows] = []
        self._others: list[bytes] = []
        self._received: list[int] = []
        self._kinds: list[int] = []
        self._read: list[Columns] = []

    def add(self, data: bytes, received_ns: int) -> None:
        """Take a message, whatever it holds."""
        self._received.append(received_ns)
        for kind, rows in enumerate(self._rows):
            if rows.fit(data):
                rows.messages.append(data)
                self._kinds.append(kind)
                break
        else:
            self._kinds.append(self._open(data))
        if len(self._received) == BLOCK:
            self._flush()

    def columns(self) -> Columns:
        """Return the numbers of all messages so far."""
        self._flush()
        return Columns._make(
            [np.concatenate(each, axis=-1) for each in zip(*self._read, strict=True)]
        )

    def _open(self, data: bytes) -> int:
        """Put a message that lies as none before it where it belongs; return where that is."""
        if not self._looks_up and len(self._rows) < MOST_LAYOUTS:
            rows = _rows(self._codecs, data)
            if rows is not None:
                self._rows.append(rows)
                return len(self._rows) - 1
        self._others.append(data)
        return -1

    def _flush(self) -> None:
        kinds = np.array(self._kinds)
        n = len(self._received)
        received_ns = np.array(self._received, np.int64)
        block = Columns(
            received_ns.copy(),
            np.zeros(n, np.bool_),
            received_ns,
            np.full((len(self._codecs), n), np.nan),
            np.ones((len(self._codecs), n), np.bool_),
        )
        for kind, rows in enumerate(self._rows):
            if rows.messages:
                rows.read_into(block, np.flatnonzero(kinds == kind), self._codecs)
                rows.messages.clear()
        for place, data in zip(np.flatnonzero(kinds < 0), self._others, strict=True):
            _read_into(block, int(place), self._codecs, data)
        self._others.clear()
        self._received.clear()
        self._kinds.clear()
        self._read.append(block)


class _Rows:
    """Messages with the same layout of bytes."""

    def __init__(self, data: bytes, lengths: Sequence[int], places: Sequence[Place | None]) -> None:
        self.messages = [data]
        self._size = len(data)
        self._begin = data[:2]
        self._lengths = [(at, data[at : at + 4]) for at in lengths]
        self._places = places

    def fit(self, data: bytes) -> bool:
        """Return whether a message lies like these."""
        if len(data) != self._size or data[:2] != self._begin:
            return False
        return all(data[at : at + 4] == length for at, length in self._lengths)

    def read_into(
        self, block: Columns, where: NDArray[np.int64], codecs: Sequence[ScalarCodec]
    ) -> None:
        """Read all messages, into some of the columns' places."""
        rows = np.frombuffer(b"".join(self.messages), np.uint8).reshape(-1, self._size)
        for k, (place, codec) in enumerate(zip(self._places, codecs, strict=True)):
            if place is not None:
                numbers = [_column(rows, at, form) for form, at in place.numbers]
                block.values[k, where] = _computed(codec.function, numbers)
                block.lacking[k, where] = False
        stamped = next((each for each in self._places if each and each.stamp_at is not None), None)
        if stamped is not None and stamped.stamp_at is not None:
            order = stamped.numbers[0][0][0]
            seconds = _column(rows, stamped.stamp_at, f"{order}i").astype(np.int64)
            nanoseconds = _column(rows, stamped.stamp_at + 4, f"{order}I").astype(np.int64)
            block.stamps_ns[where] = seconds * SECOND_NS + nanoseconds
            block.overflows[where] = nanoseconds >= SECOND_NS


def _rows(codecs: Sequence[ScalarCodec], data: bytes) -> _Rows | None:
    """Return the rows that a message starts; None if it is not a message, or has too many parts."""
    places: list[Place | None] = []
    lengths: tuple[int, ...] = ()
    for codec in codecs:
        try:
            places.append(codec.place(data))
            lengths = lengths or codec.lengths_at(data)
        except MessageError:
            places.append(None)
    if not any(places) or len(lengths) > MOST_LENGTHS:
        return None
    return _Rows(data, lengths, places)


def _column(rows: NDArray[np.uint8], at: int, number: str) -> NDArray[np.generic]:
    dtype = np.dtype(number)
    return np.ascontiguousarray(rows[:, at : at + dtype.itemsize]).view(dtype)[:, 0]


def _computed(
    function: Function, numbers: Sequence[NDArray[np.generic]]
) -> NDArray[np.generic] | list[float]:
    """Return scalars, to the bit those of single messages; numpy's functions differ from C's."""
    if function is PLAIN:
        return numbers[0]
    return [function.read(each) for each in zip(*(each.tolist() for each in numbers), strict=True)]


def _read_into(block: Columns, place: int, codecs: Sequence[ScalarCodec], data: bytes) -> None:
    """Read one message."""
    for k, codec in enumerate(codecs):
        try:
            sample = codec.sample(data, int(block.received_ns[place]))
        except StampError:
            block.overflows[place] = True
        except MessageError:
            continue
        else:
            block.stamps_ns[place] = sample.stamp_ns
            block.values[k, place] = sample.value
        block.lacking[k, place] = False
