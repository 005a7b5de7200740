"""A recording in memory: what the fusion would take of a bag, and what to compare it with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.bag.topic import BagMessage
from fuzzy_fusion_ros.batch.arrays import Reals, Stamps
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.offline.topics import Topics, codec_of, codecs_of, explanation_prefix, unit_of
from fuzzy_fusion_ros.online.guard import Guard
from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.online.trigger import Step, trigger_for
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters

Progress = Callable[[Iterable[BagMessage]], Iterable[BagMessage]]
"""Passes messages on, and shows how far it is."""

LONGEST_LATE = 1.0
"""Seconds by which the stamp of an estimate or a truth may be late before time has jumped back."""

UNREADABLE = "message does not hold the number"


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


class Recording(NamedTuple):
    """What a bag holds for the fusion.

    Attributes:
        name: The bag, for messages.
        s1: Samples of S1.
        s2: Samples of S2.
        estimate: The estimates, empty if the bag has none.
        truth: The truth, empty if the bag has none.
        series: The steps of an estimator, in the order in which the trigger makes them.
        start_ns: Log time of the bag's first message: where seconds count from.
        unit: Unit of the signal, ``""`` where the types do not tell.
        notes: What was left out and why, one line each.
    """

    name: str
    s1: Track
    s2: Track
    estimate: Track
    truth: Track
    series: Series
    start_ns: int
    unit: str
    notes: tuple[str, ...]


def read_recording(
    bag: BagReader,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda messages: messages,
) -> Recording:
    """Read the samples of a bag as a node would take them.

    Where time jumps back (a looped bag, a restarted simulation), only what comes before is
    read.

    Args:
        bag: The bag; S1 and S2 must be in it, estimate and truth may be missing.
        topics: What to read.
        parameters: Trigger, timeouts and tolerances; fields of S1 and S2 that ``topics`` lacks.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes the messages on.

    Raises:
        BagError: S1 or S2 is not in the bag or has no usable sample.
        MessageError: A field is not in its type.
    """
    bag.require_topics(topics.s1, topics.s2)
    intake = _Intake(parameters)
    tolerance = min(parameters.s1.timeout, parameters.s2.timeout)
    readers = {
        "s1": _Reader(topics.s1, tolerance, intake.take_s1),
        "s2": _Reader(topics.s2, tolerance, intake.take_s2),
        "estimate": _Reader(topics.estimate, LONGEST_LATE),
        "truth": _Reader(topics.truth, LONGEST_LATE),
    }
    codecs = codecs_of(bag, topics, parameters)
    notes: list[str] = []
    wanted = {topic for role, topic in topics.by_role().items() if role in codecs}
    for message in progress(bag.messages(wanted, start_s, end_s)):
        intake.tick(message.log_ns)
        here = [role for role in codecs if readers[role].topic == message.topic]
        if not all(
            readers[role].take(message, codecs[role], parameters.future_tolerance) for role in here
        ):
            at_s = f"{(message.log_ns - (bag.start_ns or 0)) * 1e-9:.9f}".rstrip("0")
            notes.append(
                f"stamps of {message.topic} jump back after {at_s} s: only what comes before is "
                f"used; --start {at_s} takes what comes after"
            )
            break
    for role, reader in readers.items():
        notes += reader.notes()
        if reader.is_empty and role in {"s1", "s2"}:
            why = "; ".join(reader.notes()) or "it has no message in this span"
            raise BagError(f"bag {str(bag.path)!r}: nothing on {reader.topic} can be used: {why}")
    return Recording(
        name=str(bag.path),
        s1=readers["s1"].track(),
        s2=readers["s2"].track(),
        estimate=readers["estimate"].track(),
        truth=readers["truth"].track(),
        series=intake.series(),
        start_ns=bag.start_ns or 0,
        unit=unit_of(bag.topics[topics.s2].msgtype, codecs["s2"].field.text),
        notes=(*notes, *bag.problems),
    )


def read_explanation(
    bag: BagReader, topics: Topics, start_s: float | None = None, end_s: float | None = None
) -> dict[str, Track]:
    """Return what a bag holds of weight and drift behind its estimates, by name.

    Args:
        bag: The bag.
        topics: Names the topic of the estimate, beside which they are.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
    """
    prefix = explanation_prefix(topics.estimate)
    here = [name for name in ("weight", "drift") if prefix + name in bag.topics]
    readers = {prefix + name: _Reader(prefix + name, LONGEST_LATE) for name in here}
    codecs = {each: codec_of(bag, each) for each in readers}
    for message in bag.messages(list(readers), start_s, end_s):
        readers[message.topic].take(message, codecs[message.topic], math.inf)
    return {name: readers[prefix + name].track() for name in here}


class _Reader:
    """The samples of one topic that pass its guard."""

    def __init__(
        self, topic: str, tolerance: float, then: Callable[[Sample], None] = lambda sample: None
    ) -> None:
        self.topic = topic
        self.unreadable = 0
        self._guard = Guard()
        self._tolerance = tolerance
        self._then = then
        self._jumped = False
        self._rows: list[tuple[int, float, int]] = []

    @property
    def is_empty(self) -> bool:
        return not self._rows

    def take(self, message: BagMessage, codec: ScalarCodec, future_tolerance: float) -> bool:
        """Take a message's sample or count why not; return whether time goes on."""
        log_ns = message.log_ns
        try:
            sample = codec.sample(message.data, log_ns)
        except MessageError:
            self.unreadable += 1
            return True
        admitted = self._guard.take(sample, log_ns, future_tolerance, self._tolerance, self._jump)
        if admitted and not self._jumped:
            self._rows.append((sample.stamp_ns, sample.value, log_ns))
            self._then(sample)
        return not self._jumped

    def _jump(self) -> None:
        self._jumped = True
        self._guard.restart()

    def notes(self) -> list[str]:
        dropped = {reason.value: count for reason, count in self._guard.dropped.items()}
        if self.unreadable:
            dropped[UNREADABLE] = self.unreadable
        return [f"{self.topic}: {count} left out, {reason}" for reason, count in dropped.items()]

    def track(self) -> Track:
        stamps, values, logs = zip(*self._rows, strict=True) if self._rows else ((), (), ())
        return Track(
            np.array(stamps, np.int64), np.array(values, np.float64), np.array(logs, np.int64)
        )


class _Intake:
    """The steps that the trigger makes of admitted samples, as arrays."""

    def __init__(self, parameters: Parameters) -> None:
        self._trigger = trigger_for(parameters)
        self._ticks = Ticks(parameters)
        self._s1: list[Sample] = []
        self._s2: list[Sample] = []
        self._known: list[int] = []

    def tick(self, log_ns: int) -> None:
        if self._ticks.due(log_ns) is not None:
            self._do(self._trigger.on_tick())

    def take_s1(self, sample: Sample) -> None:
        self._do(self._trigger.on_s1(sample))

    def take_s2(self, sample: Sample) -> None:
        self._do(self._trigger.on_s2(sample))

    def _do(self, step: Step) -> None:
        if step.s2 is not None:
            self._s2.append(step.s2)
        if step.s1 is not None:
            self._s1.append(step.s1)
            self._known.append(len(self._s2))

    def series(self) -> Series:
        return Series(
            s1_ns=_stamps(self._s1),
            s1=_values(self._s1),
            s2_ns=_stamps(self._s2),
            s2=_values(self._s2),
            s2_known=np.array(self._known, np.int64),
        )


def _stamps(samples: list[Sample]) -> Stamps:
    return np.array([sample.stamp_ns for sample in samples], np.int64)


def _values(samples: list[Sample]) -> Reals:
    return np.array([sample.value for sample in samples], np.float64)
