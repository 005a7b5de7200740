# SPDX-License-Identifier: Apache-2.0
"""Coverage-guided fuzzing of the bag reader: what leads to code not seen yet is mutated further."""

from __future__ import annotations

import os
import random
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

from bag.making import McapOptions, points, write_by_mcap
from mcap.writer import CompressionType

from faults.commands import no_hang
from faults.fuzzing import read
from fuzzy_fusion_ros.bag import reader

WATCHED = os.path.dirname(reader.__file__)
MESSAGES = points(24, ("/s1", "/s2"))
"""Few and in a small file, so that a random place in it is worth something."""

Step = tuple[str, int, int]
"""A file, and a line of it that came after another."""


class Guided(NamedTuple):
    """What guided fuzzing did.

    Attributes:
        cases: Files that were read.
        kept: Those that led to code not seen before.
        steps: Pairs of lines that were seen one after the other, the whole files' included.
        first_steps: Those that the whole files alone led to.
    """

    cases: int
    kept: int
    steps: int
    first_steps: int


def fuzz(folder: Path, cases: int, seed: int) -> Guided:
    """Read mutated files, mutate those further that show something new.

    It runs in a thread of its own, as only one tracer can be in a thread.

    Args:
        folder: For the files.
        cases: How many.
        seed: Of the mutations.

    Raises:
        Exception: Reading raised something that is no error of ours; the file is left there.
        TimeoutError: A file takes too long.
    """
    results: list[Guided | BaseException] = []

    def run() -> None:
        try:
            results.append(_fuzz(folder, cases, random.Random(seed)))
        except BaseException as error:  # whatever it is, the thread that waits raises it
            results.append(error)

    thread = threading.Thread(target=run, daemon=True)
    with no_hang(60.0 + 0.5 * cases):
        thread.start()
        thread.join()
    (result,) = results
    if isinstance(result, BaseException):
        raise result
    return result


def _fuzz(folder: Path, cases: int, rng: random.Random) -> Guided:
    path = folder / "guided.mcap"
    pool = [write_by_mcap(path, MESSAGES, each).read_bytes() for each in _options()]
    seen: set[Step] = set()
    for data in pool:
        seen |= _steps_of(path, data)
    first = len(seen)
    for _ in range(cases):
        data = _mutated(rng.choice(pool), rng.choice(pool), rng)
        steps = _steps_of(path, data)
        if not steps <= seen:
            seen |= steps
            pool.append(data)
    return Guided(cases, len(pool) - len(_options()), len(seen), first)


def _options() -> list[McapOptions]:
    """Return ways to write that no checksum protects: damage gets further in."""
    plain = McapOptions(enable_crcs=False, compression=CompressionType.NONE)
    return [
        plain,
        plain._replace(use_chunking=False),
        plain._replace(chunk_size=300),
        plain._replace(use_summary_offsets=False, use_statistics=False, chunk_size=300),
        McapOptions(enable_crcs=False, chunk_size=300),
    ]


def _steps_of(path: Path, data: bytes) -> set[Step]:
    """Return the steps that reading a file takes through the reader."""
    path.write_bytes(data)
    steps: set[Step] = set()

    def enter(frame: FrameType, event: str, argument: object) -> Callable[..., Any] | None:
        name = frame.f_code.co_filename
        if not name.startswith(WATCHED):
            return None
        last = frame.f_lineno

        def line(frame: FrameType, event: str, argument: object) -> Callable[..., Any]:
            nonlocal last
            steps.add((name, last, frame.f_lineno))
            last = frame.f_lineno
            return line

        return line

    before = sys.gettrace()
    sys.settrace(enter)
    try:
        read(path)
    finally:
        sys.settrace(before)
    return steps


def _mutated(one: bytes, other: bytes, rng: random.Random) -> bytes:
    """Return a file with some small changes, or two of them spliced."""
    data = bytearray(one)
    for _ in range(rng.choice((1, 1, 2, 4))):
        at = rng.randrange(len(data)) if data else 0
        kind = rng.randrange(6)
        if kind == 0:
            data[at : at + 1] = bytes([rng.randrange(256)])
        elif kind == 1:
            edge = rng.choice((0, 1, 0xFF, 1 << 31, (1 << 32) - 1, (1 << 63), (1 << 64) - 1))
            size = rng.choice((2, 4, 8))
            data[at : at + size] = (edge % (1 << 8 * size)).to_bytes(size, "little")
        elif kind == 2:
            del data[at : at + rng.randrange(1, 40)]
        elif kind == 3:
            piece = rng.randrange(max(1, len(other)))
            data[at:at] = other[piece : piece + rng.randrange(1, 200)]
        elif kind == 4:
            data[at : at + 8] = rng.randrange(len(data) + 1).to_bytes(8, "little")
        else:
            data[at:] = other[at:]
    return bytes(data)
