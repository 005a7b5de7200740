# SPDX-License-Identifier: Apache-2.0
"""A recording in memory: what the fusion takes from a bag, and what to compare it with."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag.block import one_by_one
from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.bag.topic import BagMessage
from fuzzy_fusion_ros.batch.arrays import Reals, Stamps
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.core.numerics import LARGEST
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.messages.outputs import DEVIATION, EXPLANATION, RULES, STRENGTHS
from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.offline.clean import Samples, read_clean
from fuzzy_fusion_ros.offline.topics import (
    Topics,
    codec_of,
    codecs_of,
    explanation_prefix,
    unstamped,
)
from fuzzy_fusion_ros.offline.tracks import Progress, Track
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.intake import Intake
from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.online.timeline import Timeline
from fuzzy_fusion_ros.online.verdict import Verdict
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Recording(NamedTuple):
    """What a bag holds for the fusion.

    Attributes:
        name: The bag, for messages.
        s1: Samples of S1.
        s2: Samples of S2.
        estimate: The estimates, empty if the bag has none.
        truth: The truth, empty if the bag has none.
        series: The steps of an estimator, in the order in which the trigger makes them due.
        start_ns: Log time of the bag's first message: where seconds count from.
        unit: Unit of the signal, ``""`` where the types do not say.
        period: A full turn of it, 0 if it does not wrap; the series is on continuous lines, tracks
            are as recorded.
        notes: What was left out, and why, one line each.
    """

    name: str
    s1: Track
    s2: Track
    estimate: Track
    truth: Track
    series: Series
    start_ns: int
    unit: str
    period: float
    notes: tuple[str, ...]


def read_recording(
    bag: BagReader,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
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
        progress: Passes blocks of messages on.

    Raises:
        BagError: S1 or S2 is not in the bag or has no usable sample, or a value is beyond
            ``LARGEST``.
        MessageError: A field is not in its type.
    """
    topics = topics.found_in(bag)
    topics.require_in(bag)
    codecs = codecs_of(bag, topics, parameters)
    unit = signal_unit(codecs["s1"], codecs["s2"], parameters)
    span = (start_s, end_s, progress)
    read = read_clean(bag, topics.by_role(), codecs, parameters, *span)
    notes: list[str] = []
    clock_problem = ""
    if read is None:
        read, clock_problem, notes = _read_one_by_one(bag, topics, codecs, parameters, *span)
    tracks = read.tracks
    for role, track in tracks.items():
        largest = np.max(np.abs(track.values), initial=0.0)
        if largest > LARGEST:
            raise BagError(
                f"bag {str(bag.path)!r}: {topics.by_role()[role]} has values up to {largest:.3g}, "
                f"whose squares overflow: the limit is {LARGEST:g}; is its field right?"
            )
    return Recording(
        name=str(bag.path),
        s1=tracks["s1"],
        s2=tracks["s2"],
        estimate=tracks.get("estimate", _track([])),
        truth=tracks.get("truth", _track([])),
        series=read.series,
        start_ns=bag.start_ns or 0,
        unit=unit,
        period=parameters.signal.period,
        notes=(*unstamped(topics, codecs), *clock_warning(clock_problem), *notes, *bag.problems),
    )


def clock_warning(problem: str) -> list[str]:
    """Return what is wrong with the clocks, if anything, as a line of a program."""
    return [f"WARN {problem}"] if problem else []


def _read_one_by_one(
    bag: BagReader,
    topics: Topics,
    codecs: Mapping[str, ScalarCodec],
    parameters: Parameters,
    start_s: float | None,
    end_s: float | None,
    progress: Progress,
) -> tuple[Samples, str, list[str]]:
    """Read the samples through guards and trigger.

    Returns:
        The samples; what is wrong with the clocks, ``""`` for nothing; what was left out and why.

    Raises:
        BagError: S1 or S2 has no usable sample.
    """
    intake, steps = Intake(parameters), _Steps()
    timer = Ticks(parameters)
    readers = {
        "s1": _Reader(topics.s1, codecs["s1"], intake.s1, intake.on_s1),
        "s2": _Reader(topics.s2, codecs["s2"], intake.s2, intake.on_s2),
    }
    readers |= {
        role: _alone(topics.by_role()[role], codecs[role], parameters.future_tolerance)
        for role in ("estimate", "truth")
        if role in codecs
    }
    by_topic: dict[str, list[_Reader]] = {}
    for reader in readers.values():
        by_topic.setdefault(reader.topic, []).append(reader)
    notes: list[str] = []
    for message in one_by_one(progress(bag.blocks(list(by_topic), start_s, end_s))):
        if notes:  # time has jumped back; do the clocks agree now?
            for reader in by_topic[message.topic]:
                reader.judge(message)
            if intake.clocks_known():
                break
            continue
        if timer.due(message.log_ns) is not None:
            steps.follow(intake.on_tick())
        for reader in by_topic[message.topic]:
            verdict = reader.read(message)
            if verdict.restarted:
                notes.append(_jump_note(reader, bag.start_ns or 0))
                break
            steps.follow(verdict)
    intake.finish()
    for role, reader in readers.items():
        notes += reader.notes()
        if reader.is_empty and role in {"s1", "s2"}:
            why = "; ".join(reader.notes()) or "no message in this span"
            raise BagError(f"bag {str(bag.path)!r}: no usable message on {reader.topic}: {why}")
    tracks = {role: reader.track() for role, reader in readers.items()}
    return Samples(tracks, steps.series(intake.started_ns)), intake.clock_problem(), notes


def read_explanation(
    bag: BagReader, topics: Topics, start_s: float | None = None, end_s: float | None = None
) -> dict[str, Track]:
    """Return weight, drift, deviation and firing strengths that a bag holds, by name.

    Args:
        bag: The bag.
        topics: Names the topic of the estimate; the others are named after it.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
    """
    prefix = explanation_prefix(topics.found_in(bag).estimate, topics.channel)
    fields = {name: (prefix + name, "") for name in ("weight", "drift", DEVIATION)}
    fields |= {rule: (prefix + STRENGTHS, f"name={rule}:position") for rule in RULES}
    readers = {
        name: _alone(topic, codec_of(bag, topic, path), math.inf)
        for name, (topic, path) in fields.items()
        if topic in bag.topics and bag.topics[topic].msgtype == EXPLANATION[topic[len(prefix) :]]
    }
    for message in bag.messages({each.topic for each in readers.values()}, start_s, end_s):
        for reader in readers.values():
            if reader.topic == message.topic:
                reader.read(message)
    return {name: reader.track() for name, reader in readers.items()}


def count_drops(topic: str, guard: Guard) -> list[str]:
    """Return what a guard has dropped, one line a reason."""
    return [f"{topic}: {count} dropped: {reason.value}" for reason, count in guard.dropped.items()]


class _Reader:
    """The samples of one topic that are admitted."""

    def __init__(
        self,
        topic: str,
        codec: ScalarCodec,
        guard: Guard,
        judge: Callable[[Sample, int], Verdict],
    ) -> None:
        self.topic = topic
        self._codec = codec
        self._guard = guard
        self._judge = judge
        self._rows: list[tuple[int, float, int]] = []
        self.held_log_ns = 0

    @property
    def is_empty(self) -> bool:
        return not self._rows

    def judge(self, message: BagMessage) -> tuple[Sample, Verdict]:
        """Return the sample of a message and what becomes of it."""
        try:
            sample = self._codec.sample(message.data, message.log_ns)
        except MessageError as error:
            self._guard.drop(Drop.of(error))
            return Sample(0, math.nan), Verdict(drop=Drop.of(error))
        return sample, self._judge(sample, message.log_ns)

    def read(self, message: BagMessage) -> Verdict:
        """Keep the sample of a message if it is admitted; return what becomes of it."""
        sample, verdict = self.judge(message)
        if verdict.admitted and not verdict.restarted:
            self._rows.append((sample.stamp_ns, sample.value, message.log_ns))
            self.held_log_ns = 0
        elif verdict.drop is None and not self.held_log_ns:
            self.held_log_ns = message.log_ns
        return verdict

    def notes(self) -> list[str]:
        return count_drops(self.topic, self._guard)

    def track(self) -> Track:
        return _track(self._rows)


def _track(rows: list[tuple[int, float, int]]) -> Track:
    stamps, values, logs = zip(*rows, strict=True) if rows else ((), (), ())
    return Track(np.array(stamps, np.int64), np.array(values, np.float64), np.array(logs, np.int64))


def _alone(topic: str, codec: ScalarCodec, future_tolerance: float) -> _Reader:
    """Return a reader of a topic whose samples have nothing to do with other topics'."""
    guard = Guard()
    timeline = Timeline(guard)

    def judge(sample: Sample, now_ns: int) -> Verdict:
        admission = timeline.receive(guard, sample, now_ns, future_tolerance)
        return Verdict(len(admission.admitted), admission.drop, admission.restarted)

    return _Reader(topic, codec, guard, judge)


def _jump_note(reader: _Reader, start_ns: int) -> str:
    at_s = f"{(reader.held_log_ns - start_ns) * 1e-9:.9f}".rstrip("0")
    return (
        f"timestamps of {reader.topic} jump back at {at_s} s: only what comes before is used; "
        f"--start {at_s} uses what comes after"
    )


class _Steps:
    """The steps of verdicts, as arrays."""

    def __init__(self) -> None:
        self._s1: list[Sample] = []
        self._s2: list[Sample] = []
        self._known: list[int] = []
        self._alone: list[int] = []

    def follow(self, verdict: Verdict) -> None:
        for step in verdict.steps:
            if step.s2_alone:
                self._alone.append(len(self._s2))
            if step.s2 is not None:
                self._s2.append(step.s2)
            if step.s1 is not None:
                self._s1.append(step.s1)
                self._known.append(len(self._s2))

    def series(self, started_ns: int) -> Series:
        return Series(
            s1_ns=_stamps(self._s1),
            s1=_values(self._s1),
            s2_ns=_stamps(self._s2),
            s2=_values(self._s2),
            s2_known=np.array(self._known, np.int64),
            s2_alone=np.array(self._alone, np.int64),
            started_ns=started_ns,
        )


def _stamps(samples: list[Sample]) -> Stamps:
    return np.array([sample.stamp_ns for sample in samples], np.int64)


def _values(samples: list[Sample]) -> Reals:
    return np.array([sample.value for sample in samples], np.float64)
