# SPDX-License-Identifier: Apache-2.0
"""The fault injector: pure functions from a stream to a stream and to what it must lead to."""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Callable
from typing import NamedTuple

from faults.streams import SECOND_NS, Arrival, Stream
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.online.timeline import LATE_EVIDENCE

FAR_FUTURE_NS = 2_147_483_000 * SECOND_NS
"""Later than any clock shows, and still within the 32-bit seconds of a message."""

HOUR_NS = 3600 * SECOND_NS


class Injected(NamedTuple):
    """A stream with a fault in it.

    Attributes:
        stream: The stream.
        drops: What the guard of the sensor must count, no more and no less.
        restarts: How often time must be seen to jump back.
        end: From this place in the stream on it is sound again.
        shift_ns: By how much the stamps from there on differ from those without the fault.
    """

    stream: Stream
    drops: Counter[Drop]
    restarts: int
    end: int
    shift_ns: int = 0


Fault = Callable[[Stream, str, int, int, random.Random], Injected]
"""``(stream, sensor, first, length, rng)``: spoils samples of a sensor, from its ``first`` on.

The numbers count the samples of this sensor alone.
"""


def nan(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Turn samples into NaN."""
    return _values(stream, sensor, first, length, lambda _: math.nan, Drop.NOT_FINITE)


def infinite(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Turn samples into infinities of either sign."""
    sign = rng.choice
    return _values(
        stream, sensor, first, length, lambda _: sign((1, -1)) * math.inf, Drop.NOT_FINITE
    )


def spikes(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Throw samples far off; they are finite, so they count."""

    def thrown(value: float) -> float:
        return value + rng.choice((1, -1)) * 10 ** rng.uniform(0, 4)

    return _values(stream, sensor, first, length, thrown, None)


def huge(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Turn samples into the largest numbers that there are."""
    return _values(
        stream, sensor, first, length, lambda _: rng.choice((1, -1)) * 1.7976931348623157e308, None
    )


def drop_out(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Leave samples out."""
    places = _places(stream, sensor, first, length)
    gone = set(places)
    left = [each for k, each in enumerate(stream) if k not in gone]
    return Injected(left, Counter(), 0, places[-1] + 1 - len(places))


def duplicates(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Send samples two to four times."""
    copies = {place: rng.randint(1, 3) for place in _places(stream, sensor, first, length)}
    out = [again for k, each in enumerate(stream) for again in [each] * (1 + copies.get(k, 0))]
    drops = Counter({Drop.NOT_NEWER: sum(copies.values())})
    return Injected(out, drops, 0, max(copies) + 1 + sum(copies.values()))


def reordering(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Let samples overtake others, at most four of them; those that come late are lost."""
    places = _places(stream, sensor, first, length)
    order = list(places)
    for start in range(0, len(order), 4):
        few = order[start : start + 4]
        rng.shuffle(few)
        order[start : start + 4] = few
    late, newest = 0, -1
    for place in order:
        late += place < newest
        newest = max(newest, place)
    out = list(stream)
    for place, source in zip(places, order, strict=True):
        out[place] = stream[place]._replace(sample=stream[source].sample)
    drops = Counter({Drop.NOT_NEWER: late}) if late else Counter[Drop]()
    return Injected(out, drops, 0, places[-1] + 1)


def burst(stream: Stream, sensor: str, first: int, length: int, rng: random.Random) -> Injected:
    """Hold samples back and hand all over at once, in order."""
    places = _places(stream, sensor, first, length)
    held = set(places)
    end = places[-1] + 1
    now_ns = stream[places[-1]].now_ns
    before = [each for k, each in enumerate(stream[:end]) if k not in held]
    at_once = [stream[place]._replace(now_ns=now_ns) for place in places]
    return Injected([*before, *at_once, *stream[end:]], Counter(), 0, end)


def zero_stamps(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Take the stamps away."""
    return _stamps(stream, sensor, first, length, lambda _: 0, {Drop.ZERO_STAMP: length})


def far_future(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Date samples later than any clock shows."""
    return _stamps(
        stream,
        sensor,
        first,
        length,
        lambda ns: FAR_FUTURE_NS + ns % SECOND_NS,
        {Drop.FUTURE_STAMP: length},
    )


def stamps_ahead(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Date samples 0.45 s ahead, then rightly again: a clock that was set.

    What follows is older than what came. Within the tolerance that is the same as late samples,
    until so many in a row are older that they are believed, or time has caught up.
    """
    ahead_ns = 450_000_000
    injected = _stamps(stream, sensor, first, length, lambda ns: ns + ahead_ns, {})
    newest_ns = injected.stream[injected.end - 1].sample.stamp_ns
    older = sum(
        each.sensor == sensor and each.sample.stamp_ns <= newest_ns
        for each in stream[injected.end :]
    )
    believed = older >= LATE_EVIDENCE
    drops = Counter[Drop]() if believed else Counter({Drop.NOT_NEWER: older})
    return injected._replace(drops=drops, restarts=int(believed))


def stamps_back(
    stream: Stream, sensor: str, first: int, length: int, rng: random.Random
) -> Injected:
    """Turn the clock of both sensors back by an hour, for good: a loop, a simulation reset."""
    start = _places(stream, sensor, first, 1)[0]
    moved = shifted(stream[start:], -HOUR_NS)
    stamped = [a._replace(now_ns=b.now_ns) for a, b in zip(moved, stream[start:], strict=True)]
    return Injected([*stream[:start], *stamped], Counter(), 1, start, -HOUR_NS)


FAULTS: dict[str, Fault] = {
    "NaN": nan,
    "Inf": infinite,
    "spikes": spikes,
    "huge": huge,
    "drop-out": drop_out,
    "duplicates": duplicates,
    "reordering": reordering,
    "burst": burst,
    "zero stamps": zero_stamps,
    "far future": far_future,
    "stamps ahead": stamps_ahead,
    "stamps back": stamps_back,
}

COSTS_ITS_SAMPLES_ONLY = ("NaN", "Inf", "duplicates", "zero stamps", "far future")
"""Faults whose samples are all dropped: what comes out is what comes out without them."""


def shifted(stream: Stream, by_ns: int) -> Stream:
    """Return a stream with all stamps and times moved, as by a run at another time."""
    return [
        Arrival(
            each.sensor,
            Sample(each.sample.stamp_ns + by_ns, each.sample.value),
            each.now_ns + by_ns,
        )
        for each in stream
    ]


def _places(stream: Stream, sensor: str, first: int, length: int) -> list[int]:
    places = [k for k, each in enumerate(stream) if each.sensor == sensor]
    return places[first : first + length]


def _values(
    stream: Stream,
    sensor: str,
    first: int,
    length: int,
    change: Callable[[float], float],
    reason: Drop | None,
) -> Injected:
    out = list(stream)
    places = _places(stream, sensor, first, length)
    for place in places:
        sample = stream[place].sample
        out[place] = stream[place]._replace(sample=sample._replace(value=change(sample.value)))
    drops = Counter({reason: length}) if reason else Counter[Drop]()
    return Injected(out, drops, 0, places[-1] + 1)


def _stamps(
    stream: Stream,
    sensor: str,
    first: int,
    length: int,
    change: Callable[[int], int],
    drops: dict[Drop, int],
) -> Injected:
    out = list(stream)
    places = _places(stream, sensor, first, length)
    for place in places:
        sample = stream[place].sample
        out[place] = stream[place]._replace(
            sample=sample._replace(stamp_ns=change(sample.stamp_ns))
        )
    return Injected(out, Counter(drops), 0, places[-1] + 1)
