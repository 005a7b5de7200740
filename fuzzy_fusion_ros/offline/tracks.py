# SPDX-License-Identifier: Apache-2.0
"""The samples of a topic as arrays, and what watches the messages that they are read from."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.batch.arrays import Reals, Stamps

Progress = Callable[[Iterable[Block]], Iterable[Block]]
"""Passes blocks of messages on and shows how far the work is."""


class Track(NamedTuple):
    """The samples of one topic that can be used.

    Attributes:
        stamps_ns: Their stamps, rising, shape (n,), nanoseconds.
        values: Finite, shape (n,).
        log_ns: When they were recorded, shape (n,), nanoseconds.
    """

    stamps_ns: Stamps
    values: Reals
    log_ns: Stamps
