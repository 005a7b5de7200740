# SPDX-License-Identifier: Apache-2.0
"""What is wrong with the truth of a recording, as S1 shows it: sign, unit, stamps, standstill."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Flags, Reals, seconds_since, white_noise
from fuzzy_fusion_ros.checking.check import Check, check
from fuzzy_fusion_ros.checking.clocks import NEGLIGIBLE
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.motion import Motion, motion_of
from fuzzy_fusion_ros.checking.pair import OTHER_MOVES
from fuzzy_fusion_ros.checking.samples import SensorSamples, two_sensors
from fuzzy_fusion_ros.offline.recording import Recording
from fuzzy_fusion_ros.offline.tracks import Track
from fuzzy_fusion_ros.parameters.fusion import Parameters

MOST_SAMPLES = 200_000
"""Samples of S1 and of the truth whose motion is compared, from the start on: under 1 s of work."""

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

CONVERT = "give the truth the sign and unit of s1, or choose another topic or field for it"

REMEDIES = {
    "rate": "choose another topic or field for the truth, or set s1.kind",
    "scale": CONVERT,
    "sign": CONVERT,
}
"""What to do about each finding on two sensors that is repeated of S1 and the truth."""


def truth_warnings(
    recording: Recording, parameters: Parameters, found: Check, start_s: float | None = None
) -> tuple[str, ...]:
    """Return what is wrong with the truth of a recording, a line each.

    The truth is compared with S1 as a check compares S2 with it, by their motion: that S1 has an
    offset or drifts is no fault of the truth.

    Args:
        recording: The recording; of one without a truth there is nothing to say.
        parameters: Say whether the signal wraps, and whether S1 is a rate.
        found: The check of S1 and S2; what it says of S1 is not repeated.
        start_s: Where to begin, seconds from the bag's first message.
    """
    s1, truth = _samples("s1", recording.s1), _samples("s2", recording.truth)
    if s1.values.size == 0 or truth.values.size == 0:
        return ()
    # Seconds count from the log, and these topics may be stamped by another clock.
    start_ns = recording.start_ns + int(s1.stamps_ns[0] - recording.s1.log_ns[0])
    begin_s = start_s or 0.0
    begin_ns = start_ns + round(begin_s * 1e9)
    s1, truth = (each.kept(_first(each.stamps_ns >= begin_ns)) for each in (s1, truth))
    compared = check(two_sensors(s1, truth, start_ns, parameters))
    known = {each.about for each in found.findings if each.level > Level.INFO}
    faults = [
        each._replace(text=each.text.replace("s2", "the truth"), remedy=REMEDIES[each.about])
        for each in compared.findings
        if each.level > Level.INFO and each.about in REMEDIES.keys() - known
    ]
    still = _still(recording, start_ns, begin_s)
    return tuple(f"WARN {each}" for each in (*(faults or _lag(compared, found)), *still))


def _samples(name: str, track: Track) -> SensorSamples:
    """Return the samples of a track as if they arrived when stamped: only motion is compared."""
    return SensorSamples(
        name=name,
        topic="",
        field="",
        unit="",
        is_stamped=False,
        stamps_ns=track.stamps_ns,
        overflows=np.zeros(track.values.size, np.bool_),
        arrivals_ns=track.stamps_ns,
        values=track.values,
    )


def _first(wanted: Flags) -> Flags:
    """Return which of the wanted samples are among the first ``MOST_SAMPLES`` of these."""
    first: Flags = wanted & (np.cumsum(wanted) <= MOST_SAMPLES)
    return first


def _lag(compared: Check, found: Check) -> list[Finding]:
    """Return whether the truth is behind S1, or ahead of it, by more than their intervals.

    Args:
        compared: The check of S1 and the truth.
        found: That of S1 and S2.
    """
    relation = compared.relation
    if relation is None or relation.correlation < CERTAIN:
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


def _still(recording: Recording, start_ns: int, begin_s: float) -> list[Finding]:
    """Return whether the truth repeats a value while both sensors move."""
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
    frozen = rests[_moves(s1, rests) & _moves(s2, rests)]
    if frozen.size == 0:
        return []
    begin, end = frozen[np.argmax(np.ptp(frozen, axis=1))]
    times = "once" if len(frozen) == 1 else f"{len(frozen)} times, longest"
    text = (
        f"the truth repeats its last value while s1 and s2 move, {times} from {begin:.1f} s to "
        f"{end:.1f} s: errors there mean nothing"
    )
    remedy = "leave that time out with --start and --end, or use another truth"
    return [Finding(Level.WARNING, "still", text, {}, remedy)]


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
