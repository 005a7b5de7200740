# SPDX-License-Identifier: Apache-2.0
"""The numbers of many messages of one type, as arrays.

Messages whose strings and arrays have equal lengths have every number in the same place, and most
messages of a topic do. They are stacked as rows, so that each number is a column.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages.codec import Place, ScalarCodec
from fuzzy_fusion_ros.messages.functions import PLAIN, Function
from fuzzy_fusion_ros.messages.gather import gathered
from fuzzy_fusion_ros.parameters.errors import MessageError, StampError

MOST_LAYOUTS = 16
"""Most combinations of lengths of strings and arrays whose messages are stacked as rows."""

MOST_LENGTHS = 64
"""Messages with more strings and arrays are read one by one."""


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
        self._layouts: list[_Rows] = []
        self._read = [self._blank(np.empty(0, np.int64))]

    def add(
        self,
        data: bytes,
        at: NDArray[np.int64],
        sizes: NDArray[np.int64],
        received_ns: NDArray[np.int64],
    ) -> None:
        """Take messages that lie in a buffer, whatever they hold.

        Args:
            data: The buffer.
            at: Where each message begins, shape (n,).
            sizes: How many bytes each has, shape (n,).
            received_ns: Times of receipt, shape (n,), nanoseconds.
        """
        block = self._blank(received_ns)
        left = np.arange(at.size)
        for layout in self._layouts:
            left = layout.read_into(block, data, at, sizes, left, self._codecs)
        while left.size:
            begin = int(at[left[0]])
            message = data[begin : begin + int(sizes[left[0]])]
            opened = self._open(message)
            if opened is None:
                _read_into(block, int(left[0]), self._codecs, message)
                left = left[1:]
            else:
                left = opened.read_into(block, data, at, sizes, left, self._codecs)
        self._read.append(block)

    def columns(self) -> Columns:
        """Return the numbers of all messages since the last call, and keep none of them."""
        blocks, self._read = self._read, [self._blank(np.empty(0, np.int64))]
        columns = [list(each) for each in zip(*blocks, strict=True)]
        del blocks
        return Columns._make(
            np.concatenate(columns.pop(0), axis=-1) for _ in Columns._fields
        )  # one after the other: a day of samples is in memory once, not twice

    def _blank(self, received_ns: NDArray[np.int64]) -> Columns:
        n = received_ns.size
        return Columns(
            received_ns.copy(),
            np.zeros(n, np.bool_),
            received_ns,
            np.full((len(self._codecs), n), np.nan),
            np.ones((len(self._codecs), n), np.bool_),
        )

    def _open(self, message: bytes) -> _Rows | None:
        """Return the layout that a message is the first of; None if it is read by itself."""
        if self._looks_up or len(self._layouts) == MOST_LAYOUTS:
            return None
        layout = _rows(self._codecs, message)
        if layout is not None:
            self._layouts.append(layout)
        return layout


class _Rows:
    """Messages with the same layout of bytes."""

    def __init__(self, data: bytes, lengths: Sequence[int], places: Sequence[Place | None]) -> None:
        self._size = len(data)
        self._same = [("<u2", 0), *(("<u4", at) for at in lengths)]
        self._first = np.frombuffer(data, np.uint8)[np.newaxis]
        self._places = places

    def read_into(
        self,
        block: Columns,
        data: bytes,
        at: NDArray[np.int64],
        sizes: NDArray[np.int64],
        left: NDArray[np.int64],
        codecs: Sequence[ScalarCodec],
    ) -> NDArray[np.int64]:
        """Read those of the messages that lie like these; return the others."""
        rows, alike = self.fitting(data, at[left], sizes[left])
        where = left[alike]
        if not where.size:
            return left
        for k, (place_, codec) in enumerate(zip(self._places, codecs, strict=True)):
            if place_ is not None:
                numbers = [_column(rows, begin, form) for form, begin in place_.numbers]
                block.values[k, where] = _computed(codec.function, numbers)
                block.lacking[k, where] = False
        stamped = next((each for each in self._places if each and each.stamp_at is not None), None)
        if stamped is not None and stamped.stamp_at is not None:
            order = stamped.numbers[0][0][0]
            seconds = _column(rows, stamped.stamp_at, f"{order}i").astype(np.int64)
            nanoseconds = _column(rows, stamped.stamp_at + 4, f"{order}I").astype(np.int64)
            block.stamps_ns[where] = seconds * SECOND_NS + nanoseconds
            block.overflows[where] = nanoseconds >= SECOND_NS
        others: NDArray[np.int64] = left[~alike]
        return others

    def fitting(
        self, data: bytes, at: NDArray[np.int64], sizes: NDArray[np.int64]
    ) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
        """Return the rows of the messages that lie like these, and which ones do."""
        alike = sizes == self._size
        found = gathered(data, at[alike], f"V{self._size}")
        rows = found.view(np.uint8).reshape(-1, self._size)
        if not len(rows):
            return rows, alike
        fit = np.ones(len(rows), np.bool_)
        for form, place in self._same:
            fit &= _column(rows, place, form) == _column(self._first, place, form)
        alike[alike] = fit
        return (rows if fit.all() else rows[fit]), alike


def rows_alike(
    codec: ScalarCodec, data: bytes, at: NDArray[np.int64], sizes: NDArray[np.int64]
) -> NDArray[np.uint8] | None:
    """Return messages as rows if all of them are laid out as the first is, else ``None``.

    Args:
        codec: Reads them.
        data: A buffer that they lie in.
        at: Where each begins, shape (n,).
        sizes: How many bytes each has, shape (n,).
    """
    if not at.size:
        return np.empty((0, 0), np.uint8)
    layout = _rows([codec], data[int(at[0]) : int(at[0] + sizes[0])])
    if layout is None:
        return None
    rows, alike = layout.fitting(data, at, sizes)
    return rows if alike.all() else None


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


def _column(rows: NDArray[np.uint8], at: int, number: str) -> NDArray[Any]:
    """Return a view of the numbers that begin at a byte of each row."""
    return np.ndarray((len(rows),), number, rows, at, (rows.shape[1],))


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
