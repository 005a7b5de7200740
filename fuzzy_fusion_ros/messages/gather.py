# SPDX-License-Identifier: Apache-2.0
"""Records in a buffer, wherever they begin in it, as arrays and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray


def gathered(data: bytes, at: NDArray[np.int64], dtype: DTypeLike) -> NDArray[Any]:
    """Return a copy of the records at some places, aligned or not, shape (n,).

    Args:
        data: The buffer.
        at: Where each record begins, shape (n,); all of them end in the buffer.
        dtype: What a record is; ``V60`` for 60 bytes of anything.
    """
    kind = np.dtype(dtype)
    if not at.size:
        return np.empty(0, kind)
    return _everywhere(data, kind)[at]


def scatter(data: bytearray, at: NDArray[np.int64], records: NDArray[Any]) -> None:
    """Write records to some places of a buffer; as :func:`gathered` reads them."""
    if at.size:
        _everywhere(data, records.dtype)[at] = records


def _everywhere(data: bytes | bytearray, kind: np.dtype[Any]) -> NDArray[Any]:
    """Return a view in which element ``k`` is the record that begins at byte ``k``."""
    return np.ndarray((len(data) - kind.itemsize + 1,), kind, data, strides=(1,))
