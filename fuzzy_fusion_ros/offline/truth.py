# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the truth of a recording, as the sensors show it, and with these by it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, seconds_since, white_noise
from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.clocks import NEGLIGIBLE
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.majority import RESPECTS, TRUTH, Compared, Three
from fuzzy_fusion_ros.checking.motion import Motion, motion_of
from fuzzy_fusion_ros.checking.pair import OTHER_MOVES
from fuzzy_fusion_ros.checking.recent import warnings
from fuzzy_fusion_ros.checking.relation import Kind
from fuzzy_fusion_ros.checking.samples import SensorSamples, two_sensors
from fuzzy_fusion_ros.offline.check import warning_lines
from fuzzy_fusion_ros.offline.recording import Recording
from fuzzy_fusion_ros.offline.tracks import Track
from fuzzy_fusion_ros.parameters.fusion import Parameters

MOST_SAMPLES = 200_000
"""Samples of each topic whose motion is compared, from the start on: under 1 s of work."""

CERTAIN = 0.9
"""A lag is named only from this correlation on."""

LAG_INTERVALS = 3.0
"""A lag of up to this many intervals of S1, or one of S2 or of the truth, and ``NEGLIGIBLE``
seconds more is none."""

STILL_FOR = (2.0, 10)
"""A truth that does not change for this many seconds and this many intervals of the slowest topic
stands still."""

MIDDLE = (0.25, 0.75)
"""Sensors that move meanwhile do so in the middle half of that time: at first they may lag."""

LEAVE_OUT = "leave that time out with --start and --end, or use another truth"


class Suitability(NamedTuple):
    """Whether the sensors and the truth of a recording suit each other.

    Attributes:
        lines: What is wrong with them, a line each.
        truth_is_wrong: Whether the truth does not suit the sensors, so that errors mean nothing;
            where it only stands still or saturates for a while, the others count.
    """

    lines: tuple[str, ...]
    truth_is_wrong: bool


def suitability(
    recording: Recording, parameters: Parameters, found: Check, start_s: float | None = None
) -> Suitability:
    """Return what is wrong with the sensors and the truth of a recording.

    All three are compared by their motion: that S1 has an offset or drifts is no fault of the
    truth. What differs from the other two is wrong.

    Args:
        recording: The recording; of one without a truth only the check counts.
        parameters: Say whether the signal wraps, whether S1 is a rate, and the scales.
        found: The check of S1 and S2.
        start_s: Where to begin, seconds from the bag's first message.
    """
    tracks = recording.s1, recording.s2, recording.truth
    if any(each.values.size == 0 for each in tracks):
        return Suitability(warning_lines(found), truth_is_wrong=False)
    # Seconds count from the log, and these topics may be stamped by another clock.
    s1_ns = int(recording.s1.stamps_ns[0])
    start_ns = recording.start_ns + s1_ns - int(recording.s1.log_ns[0])
    begin_s = start_s or 0.0
    s1, s2, truth = (_samples(each, start_ns + round(begin_s * 1e9)) for each in tracks)
    s1 = s1._replace(scale=parameters.s1.scale)
    sensors = two_sensors(s1, _as_s2(truth), start_ns, parameters)
    expected = Kind.S1_RATE if sensors.is_rate else Kind.VALUE
    only_units = sensors.period > 0.0
    s1_s2 = Compared("s1", "s2", found, expected, only_units)
    s1_truth = Compared("s1", TRUTH, check(sensors), expected, only_units)
    of_sensors, of_truth = s1_s2.differences, list[Finding]()
    if of_sensors or s1_truth.differences or None in {found.relation, s1_truth.found.relation}:
        sensors = sensors._replace(s1=truth, s2=_as_s2(s2), is_rate=False)
        truth_s2 = Compared(TRUTH, "s2", check(sensors), Kind.VALUE, only_units)
        three = Three(s1_s2, s1_truth, truth_s2)
        of_sensors, of_truth = three.findings(parameters.s2.scale)
    of_truth += _lag(s1_truth.found, found)
    said = [each for each in warnings(found) if each.about not in RESPECTS]
    passing = []
    if all(each.about != "unrelated" for each in of_truth):
        passing = _saturated(s1_truth.found)
        passing += _still(recording, start_ns, begin_s, at_ends=bool(passing))
    lines = (*of_sensors, *said, *of_truth, *passing)
    return Suitability(tuple(f"WARN {each}" for each in lines), truth_is_wrong=bool(of_truth))


def _samples(track: Track, begin_ns: int) -> SensorSamples:
    """Return what of a track is compared, as if it arrived when stamped: only motion counts."""
    wanted = track.stamps_ns >= begin_ns
    wanted &= np.cumsum(wanted) <= MOST_SAMPLES
    stamps_ns, values = track.stamps_ns[wanted], track.values[wanted]
    return SensorSamples(
        name="s1",
        topic="",
        field="",
        unit="",
        is_stamped=False,
        stamps_ns=stamps_ns,
        overflows=np.zeros(values.size, np.bool_),
        arrivals_ns=stamps_ns,
        values=values,
    )


def _as_s2(samples: SensorSamples) -> SensorSamples:
    return samples._replace(name="s2")


def _lag(compared: Check, found: Check) -> list[Finding]:
    """Return whether the truth is behind S1, or ahead of it, by more than their intervals.

    Args:
        compared: The check of S1 and the truth.
        found: That of S1 and S2.
    """
    relation = compared.relation
    is_rate = any(each.about == "rate" for each in compared.findings)
    if relation is None or is_rate or relation.correlation < CERTAIN:
        return []
    characters = (*compared.characters.values(), *found.characters.values())
    longest = max(each.interval for each in characters)
    several = LAG_INTERVALS * compared.characters["s1"].interval
    if abs(relation.lag) <= NEGLIGIBLE + max(longest, several):
        return []
    lags = relation.lag > 0.0
    text = (
        f"the truth {'lags' if lags else 'leads'} s1 by {abs(relation.lag):.2g} s: errors are "
        f"measured against where the signal {'was' if lags else 'will be'}"
    )
    remedy = "correct its timestamps" if lags else "correct its timestamps, or those of s1"
    return [Finding(Level.WARNING, "lag", text, {"correlation": relation.correlation}, remedy)]


def _saturated(compared: Check) -> list[Finding]:
    """Return whether the truth saturates, by its check with S1."""
    return [
        each._replace(text=f"{TRUTH}{each.text[2:].partition(';')[0]}", remedy=LEAVE_OUT)
        for each in compared.findings
        if each.about == "saturated" and each.text.startswith("s2 ")
    ]


def _still(recording: Recording, start_ns: int, begin_s: float, *, at_ends: bool) -> list[Finding]:
    """Return whether the truth repeats a value while both sensors move.

    Args:
        recording: The recording.
        start_ns: Where seconds count from, as these topics are stamped.
        begin_s: Where to begin.
        at_ends: Whether the least and the largest value may be repeated.
    """
    series = recording.series
    truth, s1, s2 = (
        motion_of(seconds_since(start_ns, stamps_ns), values).between(begin_s, np.inf)
        for stamps_ns, values in (
            (recording.truth.stamps_ns, recording.truth.values),
            (series.s1_ns, series.s1),
            (series.s2_ns, series.s2),
        )
    )
    if min(truth.intervals, s1.intervals, s2.intervals) < 2:
        return []
    seconds, intervals = STILL_FOR
    longest = max(truth.interval, s1.interval, s2.interval)
    changes = np.flatnonzero(np.diff(truth.values) != 0.0)
    edges = np.concatenate([[-1], changes, [truth.intervals]])
    equal = np.flatnonzero(np.diff(edges) > intervals)
    rests = np.stack([truth.time_s[edges[equal] + 1], truth.time_s[edges[equal + 1]]], axis=1)
    rests = rests[np.ptp(rests, axis=1) >= max(seconds, intervals * longest)]
    if at_ends:
        ends = truth.values.min(), truth.values.max()
        rests = rests[~np.isin(truth.values[np.searchsorted(truth.time_s, rests[:, 0])], ends)]
    frozen = rests[_moves(s1, rests) & _moves(s2, rests)]
    if frozen.size == 0:
        return []
    begin, end = frozen[np.argmax(np.ptp(frozen, axis=1))]
    times = "once" if len(frozen) == 1 else f"{len(frozen)} times, longest"
    text = (
        f"the truth repeats its last value while s1 and s2 move, {times} from {begin:.1f} s to "
        f"{end:.1f} s: errors there mean nothing"
    )
    return [Finding(Level.WARNING, "still", text, {}, LEAVE_OUT)]


def _moves(motion: Motion, spans: Reals) -> Flags:
    """Return in which of some spans, shape (k, 2), seconds, a sensor moves, shape (k,)."""
    least = OTHER_MOVES[0] * float(np.std(motion.values))
    noise = OTHER_MOVES[1] * white_noise(motion.values)
    found = np.zeros(len(spans), np.bool_)
    for k, (begin, end) in enumerate(np.searchsorted(motion.time_s, spans)):
        during = motion.values[begin:end]
        if during.size:
            low, high = np.quantile(during, MIDDLE)
            found[k] = high - low >= least > 0.0 and np.std(during) >= noise
    return found
