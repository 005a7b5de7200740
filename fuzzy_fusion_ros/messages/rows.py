# SPDX-License-Identifier: Apache-2.0
"""Messages of one layout as rows of bytes, to be filled with numbers all at once."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from typing import cast

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.numerics import SECOND_NS
from fuzzy_fusion_ros.messages.codec import Place, ScalarCodec
from fuzzy_fusion_ros.messages.functions import PLAIN
from fuzzy_fusion_ros.messages.type_fields import FLOATS

Rows = NDArray[np.uint8]
"""Messages of the same length, shape (n, bytes)."""

_END_OF_STAMPS = 2**31 * SECOND_NS


def repeated(message: bytes, times: int) -> Rows:
    """Return a message repeated as rows."""
    return np.tile(np.frombuffer(message, np.uint8), (times, 1))


def put(rows: Rows, at: int, form: str, numbers: NDArray[np.float64] | NDArray[np.int64]) -> bool:
    """Write a number into each row.

    Args:
        rows: The rows; only whole ones that follow one another in memory.
        at: Where the number begins.
        form: Its byte order and type, as :mod:`struct` writes them.
        numbers: Shape (n,).

    Returns:
        Whether all fit: infinite ones do not.
    """
    if not len(rows):
        return True
    column = np.ndarray((len(rows),), form, rows, at, (rows.shape[1],))
    with np.errstate(over="ignore"):
        column[...] = numbers
    return bool(np.isfinite(column).all())


def put_same(rows: Rows, places: Iterable[tuple[str, int]], numbers: Iterable[float]) -> None:
    """Write the same numbers into all rows, each at its place."""
    for (form, at), number in zip(places, numbers, strict=True):
        octets = struct.pack(form, number if form[1] in "fd" else int(number))
        rows[:, at : at + len(octets)] = np.frombuffer(octets, np.uint8)


def put_stamps(rows: Rows, at: int, order: str, stamps_ns: NDArray[np.int64]) -> bool:
    """Write a stamp into each row; return whether all fit into 32-bit seconds.

    Args:
        rows: As for :func:`put`.
        at: Where the stamp begins.
        order: Its byte order, as :mod:`struct` writes it.
        stamps_ns: The stamps, not negative, shape (n,), nanoseconds.
    """
    if (stamps_ns >= _END_OF_STAMPS).any():
        return False
    seconds, nanoseconds = np.divmod(stamps_ns, SECOND_NS)
    put(rows, at, f"{order}i", seconds)
    return put(rows, at + 4, f"{order}I", nanoseconds)


def fills(codec: ScalarCodec) -> bool:
    """Return whether :func:`filled` can write the scalars of a codec.

    It can if they are numbers as they are, which do not have to be rounded or looked up.
    """
    field = codec.field
    is_real = all(path.number in FLOATS for path in field.paths)
    return field.function is PLAIN and is_real and not field.looks_up


def filled(
    rows: Rows,
    codec: ScalarCodec,
    place: Place,
    values: NDArray[np.float64],
    stamps_ns: NDArray[np.int64],
) -> bool:
    """Write scalars and stamps into rows, as templates do one by one.

    Args:
        rows: Messages of one layout, one for each scalar.
        codec: Of their type; :func:`fills` must say that it can.
        place: Where number and stamp are.
        values: The scalars, shape (n,).
        stamps_ns: The stamps, shape (n,), nanoseconds.

    Returns:
        Whether all fit.
    """
    write = codec.function.write
    if write is None:
        return False
    on_arrays = cast(Callable[..., tuple[NDArray[np.float64]]], write)  # the same arithmetic
    with np.errstate(over="ignore", invalid="ignore"):
        (numbers,) = on_arrays((), values)
    ((form, at),) = place.numbers
    fit = put(rows, at, form, numbers)
    if place.stamp_at is not None:
        fit = put_stamps(rows, place.stamp_at, form[0], stamps_ns) and fit
    return fit
