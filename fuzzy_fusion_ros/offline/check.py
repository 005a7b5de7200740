# SPDX-License-Identifier: Apache-2.0
"""Checks and surveys of a bag: its samples as recorded, before any filter."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import islice, takewhile
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag.block import Block, first
from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.batch.arrays import Flags, seconds_since
from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.direction import meaningless
from fuzzy_fusion_ros.checking.motion import motion_of
from fuzzy_fusion_ros.checking.presets import Advice, advise
from fuzzy_fusion_ros.checking.recent import warnings
from fuzzy_fusion_ros.checking.samples import SensorSamples, two_sensors
from fuzzy_fusion_ros.checking.survey import Field, Together, moves, survey
from fuzzy_fusion_ros.checking.values import on_lines, wrap_of
from fuzzy_fusion_ros.messages import ScalarCodec, computed_fields, numeric_fields
from fuzzy_fusion_ros.messages.field_path import call_in
from fuzzy_fusion_ros.messages.functions import FUNCTIONS, TURN
from fuzzy_fusion_ros.messages.units import unit_of, unit_read
from fuzzy_fusion_ros.offline.raw import RawSamples, Source, read_raw
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of
from fuzzy_fusion_ros.offline.tracks import Progress
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters

SENSORS = ("s1", "s2")

MOST_NUMBERS = 2_000_000
"""Numbers that a survey reads; of longer bags, every n-th message."""

FEWEST_MESSAGES = 500
"""Messages of each topic that a survey reads at least, however many numbers are in them."""

FIRST_MESSAGES = 100_000
"""Topics without a message among this many of the bag are left out of a survey."""

MOST_ELEMENTS = 64
"""Longer arrays are images and clouds of points rather than sensors; a survey leaves them out."""

WARNED_MESSAGES = 100_000
"""Messages of S1 and S2 that are checked where a check is a by-product: some 0.5 s of work."""

FRAMED = 64
"""First messages of each topic in a block whose frame is looked at, besides the last."""

MOST_FRAMES = 100
"""Changes of a frame that are kept."""

FARTHEST_STAMP = 1.0
"""Where stamps are further than this many seconds from the log, a survey goes by the log."""

LENGTH_OF = "length of "
"""Before the name of a direction: the length of the vector that has it."""


def check_bag(
    bag: BagReader,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
) -> Check:
    """Check the two sensors of a bag.

    Args:
        bag: The bag; S1 and S2 must be in it.
        topics: Where they are, as the bag spells them.
        parameters: Fields of S1 and S2 that ``topics`` lacks.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.

    Raises:
        BagError: S1 or S2 is not in the bag, or neither has a message in the span.
        MessageError: A field is not in its type, or in none of its messages.
    """
    sources = _sensors(bag, topics, parameters, start_s)
    frames = _Frames(sources)
    raw = _read(bag, sources, start_s, end_s, lambda blocks: frames.seen_in(progress(blocks)))
    for name, source in sources.items():
        if raw[name].unreadable and not raw[name].values.size:
            _refuse(bag, source, start_s, end_s)
    if not any(each.values.size for each in raw.values()):
        raise BagError(
            f"bag {str(bag.path)!r}: no message of {topics.s1} or {topics.s2} in this span can be "
            "read"
        )
    return _checked(bag, sources, raw, frames, parameters)


def check_start(
    bag: BagReader,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
) -> Check:
    """Check the first messages of the two sensors of a bag, for replay, score and tune.

    Only the first ``WARNED_MESSAGES`` are read. If they hold too few numbers, :func:`warning_lines`
    has nothing to say: the rest of the bag may have enough.

    Args:
        bag: The bag; S1 and S2 must be in it.
        topics: Where they are, with or without the leading slash.
        parameters: As :func:`check_bag` takes them.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.

    Raises:
        BagError: S1 or S2 is not in the bag, or the bag ends before the span.
        MessageError: A field is not in its type.
    """
    sources = _sensors(bag, topics.found_in(bag), parameters, start_s)
    frames = _Frames(sources)
    raw = _read(
        bag,
        sources,
        start_s,
        end_s,
        lambda blocks: frames.seen_in(first(blocks, WARNED_MESSAGES)),
    )
    return _checked(bag, sources, raw, frames, parameters)


def warning_lines(found: Check) -> tuple[str, ...]:
    """Return what a check warns of in replay, score and tune, a line each."""
    return tuple(f"WARN {each}" for each in warnings(found))


def warnings_of(
    bag: BagReader,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
) -> tuple[str, ...]:
    """Return what :func:`check_start`, which takes the same arguments, warns of, a line each."""
    return warning_lines(check_start(bag, topics, parameters, start_s, end_s))


def _sensors(
    bag: BagReader, topics: Topics, parameters: Parameters, start_s: float | None
) -> dict[str, Source]:
    topics.require_in(bag)
    bag.require_messages_from(start_s)
    names = topics.by_role()
    codecs = codecs_of(bag, topics, parameters, SENSORS)
    return {name: Source(names[name], codecs[name]) for name in SENSORS}


def _checked(
    bag: BagReader,
    sources: Mapping[str, Source],
    raw: Mapping[str, RawSamples],
    frames: _Frames,
    parameters: Parameters,
) -> Check:
    s1, s2 = (_samples(name, sources[name], raw, frames) for name in SENSORS)
    return check(two_sensors(s1, s2, bag.start_ns or 0, parameters))


def _read(
    bag: BagReader,
    sources: Mapping[str, Source],
    start_s: float | None,
    end_s: float | None,
    progress: Progress,
    every: Mapping[str, int] | None = None,
) -> dict[str, RawSamples]:
    """Read samples, as :func:`read_raw` does, and with directions the lengths of their vectors."""
    lengths = {LENGTH_OF + name: _length(bag, each) for name, each in sources.items()}
    known = {name: each for name, each in lengths.items() if each is not None}
    return read_raw(bag, {**sources, **known}, start_s, end_s, progress, every)


def _length(bag: BagReader, source: Source) -> Source | None:
    """Return the length of the vector whose direction is read; of a heading, it is the speed.

    Tilt is left out: what an accelerometer measures points up near 1 g, not where it is long.
    """
    text, type_name = source.codec.field.text, source.codec.type_name
    call = call_in(text)
    if call is None or call.name not in {"atan2", "yaw"}:
        return None
    if call.name == "yaw":
        sizes = [each for each in computed_fields(bag.types, type_name) if "norm" in each]
        text = next((each for each in sizes if unit_of(type_name, each) == "m/s"), "")
        if not text:
            return None
    codec = ScalarCodec(bag.types, type_name, text)
    (codec.function,) = FUNCTIONS["norm"]
    return Source(source.topic, codec)


def _meaningless(name: str, raw: Mapping[str, RawSamples]) -> Flags | None:
    """Return where a direction means nothing; None if that is nowhere or not known."""
    angles, lengths = raw[name].values, raw.get(LENGTH_OF + name)
    if lengths is None or lengths.values.size != angles.size:
        return None
    found = meaningless(angles, lengths.values, TURN)
    return found if found.any() else None


class _Frames:
    """The frames of some messages of each block, and the names of the element that is read."""

    def __init__(self, sources: Mapping[str, Source]) -> None:
        self._sources = sources
        self._found: dict[str, list[str]] = {name: [] for name in sources}
        self._elements: dict[str, dict[str, None]] = {name: {} for name in sources}

    def seen_in(self, blocks: Iterable[Block]) -> Iterator[Block]:
        """Yield blocks, once looked at."""
        for block in blocks:
            for name, source in self._sources.items():
                which = block.which(source.topic)
                which = np.union1d(which[:FRAMED], which[-1:])
                self._look(block.chosen(which), source, name)
            yield block

    def of(self, name: str) -> tuple[str, ...]:
        """Return each frame of a sensor whenever it is not that of the message before."""
        return tuple(self._found[name])

    def elements(self, name: str) -> tuple[str, ...]:
        """Return each name that the element of a sensor has had."""
        return tuple(self._elements[name])

    def _look(self, block: Block, source: Source, name: str) -> None:
        found = self._found[name]
        for message in block.messages():
            if _reads(source.codec, message.data):
                frame = source.codec.frame(message.data)
                if found[-1:] != [frame] and len(found) < MOST_FRAMES:
                    found.append(frame)
                element = source.codec.element_name(message.data)
                if element and len(self._elements[name]) < MOST_FRAMES:
                    self._elements[name][element] = None


def _refuse(bag: BagReader, source: Source, start_s: float | None, end_s: float | None) -> None:
    """Raise what the first unreadable message of a topic lacks, such as an array element."""
    for message in bag.messages([source.topic], start_s, end_s):
        try:
            source.codec.sample(message.data, message.log_ns)
        except MessageError as error:
            raise MessageError(f"topic {source.topic}: {error}") from None


def _samples(
    name: str, source: Source, found: Mapping[str, RawSamples], frames: _Frames
) -> SensorSamples:
    codec, raw = source.codec, found[name]
    return SensorSamples(
        name=name,
        topic=source.topic,
        field=codec.field.text,
        unit=unit_read(codec),
        is_stamped=codec.is_stamped,
        stamps_ns=raw.stamps_ns,
        overflows=raw.overflows,
        arrivals_ns=raw.log_ns,
        values=raw.values,
        scale=codec.scale,
        unreadable=raw.unreadable,
        frames=frames.of(name),
        elements=frames.elements(name),
        meaningless=_meaningless(name, found),
    )


class Survey(NamedTuple):
    """What the numbers of a bag have in common.

    Attributes:
        together: Those that move together, most certain first.
        advice: Presets that suit them.
    """

    together: list[Together]
    advice: list[Advice]


def survey_bag(
    bag: BagReader,
    topics: Topics,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
) -> Survey:
    """Return which numbers in a bag move together, and which presets suit them.

    Args:
        bag: The bag.
        topics: Name the truth and the estimate, which are no sensors for a preset.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.

    Raises:
        BagError: No message from ``start_s`` on, or none with a number.
    """
    bag.require_messages_from(start_s)
    sources = _sources(bag)
    if not sources:
        raise BagError(f"bag {str(bag.path)!r} has no message with a number")
    raw = _read(bag, sources, start_s, end_s, progress, _strides(bag, sources.values()))
    fields = list(_fields(sources, raw, bag.start_ns or 0))
    together = survey(fields)
    others = {topics.truth, topics.estimate}
    sensors = [each for each in fields if moves(each.motion) and each.topic not in others]
    pairs = [each for each in together if not {each.s1.topic, each.s2.topic} & others]
    return Survey(together, advise(sensors, pairs))


def _sources(bag: BagReader) -> dict[str, Source]:
    """Return where all numbers of a bag are, variances and long arrays left out."""
    found = {}
    codec_of = functools.cache(functools.partial(ScalarCodec, bag.types))  # topics share types
    for topic, data in _first_messages(bag).items():
        for codec in _codecs(bag, bag.topics[topic].msgtype, data, codec_of):
            found[f"{topic} {codec.field.text}"] = Source(topic, codec)
    return found


def _first_messages(bag: BagReader) -> dict[str, bytes]:
    """Return the first message of each topic that has one among the first of the bag."""
    found: dict[str, bytes] = {}
    for message in islice(bag.messages(), FIRST_MESSAGES):
        found.setdefault(message.topic, message.data)
        if len(found) == len(bag.topics):
            break
    return found


def _codecs(
    bag: BagReader, msgtype: str, data: bytes, codec_of: Callable[[str, str], ScalarCodec]
) -> Iterator[ScalarCodec]:
    """Yield what reads the numbers of a type, each element of a short array by itself."""
    try:
        paths = numeric_fields(bag.types, msgtype)
        computed = computed_fields(bag.types, msgtype)
    except MessageError:
        return
    chosen = [each for each in computed if "norm" not in each or each.endswith("linear)")]
    yield from _readers(codec_of, msgtype, [each for each in chosen if "[" not in each])
    for path in paths:
        if "variance" in path.lower() or "=" in path:
            continue
        if "[0]" not in path:
            yield from _readers(codec_of, msgtype, [path])
            continue
        elements = [path.replace("[0]", f"[{k}]", 1) for k in range(MOST_ELEMENTS + 1)]
        codecs = list(
            takewhile(lambda each: _reads(each, data), _readers(codec_of, msgtype, elements))
        )
        if len(codecs) <= MOST_ELEMENTS:
            yield from codecs


def _readers(
    codec_of: Callable[[str, str], ScalarCodec], msgtype: str, paths: Sequence[str]
) -> Iterator[ScalarCodec]:
    for path in paths:
        try:
            yield codec_of(msgtype, path)
        except MessageError:  # beyond the bound of the array, or a type too large to be read
            return


def _reads(codec: ScalarCodec, data: bytes) -> bool:
    try:
        codec.sample(data, 0)
    except MessageError:
        return False
    return True


def _strides(bag: BagReader, sources: Iterable[Source]) -> dict[str, int]:
    """Return of each topic, every how many messages one is read."""
    numbers = Counter(each.topic for each in sources)
    counts = {topic: bag.topics[topic].message_count or 0 for topic in numbers}
    total = sum(numbers[topic] * count for topic, count in counts.items())
    every = -(-total // MOST_NUMBERS)
    return {topic: max(1, min(every, count // FEWEST_MESSAGES)) for topic, count in counts.items()}


def _fields(
    sources: Mapping[str, Source], raw: Mapping[str, RawSamples], start_ns: int
) -> Iterator[Field]:
    """Yield the fields that can be surveyed."""
    for name, source in sources.items():
        samples = raw[name]
        finite = np.isfinite(samples.values)
        if not finite.any():
            continue
        apart = np.abs(samples.log_ns - samples.stamps_ns) * 1e-9
        times_ns = samples.stamps_ns if np.median(apart) <= FARTHEST_STAMP else samples.log_ns
        values, nothing = samples.values[finite], _meaningless(name, raw)
        sound = np.ones(values.size, np.bool_) if nothing is None else ~nothing[finite]
        known = values[sound]
        codec = source.codec
        yield Field(
            source.topic,
            codec.field.text,
            unit_read(codec),
            motion_of(
                seconds_since(start_ns, times_ns[finite]),
                on_lines(wrap_of(known).unwrapped(known), sound),
            ),
        )
