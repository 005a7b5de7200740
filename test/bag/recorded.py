# SPDX-License-Identifier: Apache-2.0
"""Bags of stamped scalars, as the tests of replay and score want them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from bag.making import POINT, point_data

from fuzzy_fusion_ros.bag import BagMessage, BagWriter, open_bag
from fuzzy_fusion_ros.offline.recording import Recording, read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters

SECOND = 1_000_000_000
BEGIN_NS = 1_700_000_000 * SECOND


class Scalar(NamedTuple):
    """A stamped scalar on a topic; recorded at its stamp unless ``log_s`` says otherwise."""

    topic: str
    time_s: float
    value: float
    log_s: float | None = None


def at(time_s: float) -> int:
    """Return a stamp, ns."""
    return BEGIN_NS + round(time_s * SECOND)


def message(scalar: Scalar) -> BagMessage:
    """Return a scalar as a message of a bag."""
    log_s = scalar.time_s if scalar.log_s is None else scalar.log_s
    data = point_data(at(scalar.time_s), scalar.value)
    return BagMessage(scalar.topic, POINT, at(log_s), data)


def write_scalars(path: Path, scalars: Iterable[Scalar]) -> Path:
    """Write a bag of scalars in the order given."""
    with BagWriter(path) as writer:
        for each in scalars:
            writer.write(*message(each))
    return path


def swing(seconds: float = 5.0, *, estimate: bool = True, truth: bool = True) -> list[Scalar]:
    """Return a slow swing: S1 at 100 Hz and off by 0.1, S2 at 10 Hz and late, 100 Hz truth."""
    scalars = []
    for k in range(round(seconds * 100)):
        time_s = k * 0.01
        value = time_s * (seconds - time_s)
        if truth:
            scalars.append(Scalar("/truth", time_s, value))
        if k % 10 == 0:
            late = max(time_s - 0.1, 0.0)
            scalars.append(Scalar("/s2", time_s, late * (seconds - late)))
        scalars.append(Scalar("/s1", time_s, value + 0.1))
        if estimate:
            scalars.append(Scalar("/estimate", time_s, value + 0.01))
    return scalars


def read(
    path: Path,
    topics: Topics | None = None,
    parameters: Parameters | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
) -> Recording:
    """Read a bag as a recording."""
    with open_bag(path) as bag:
        return read_recording(bag, topics or Topics(), parameters or Parameters(), start_s, end_s)


def messages(path: Path, topics: Sequence[str] | None = None) -> list[BagMessage]:
    """Return the messages of a bag."""
    with open_bag(path) as bag:
        return list(bag.messages(topics))
