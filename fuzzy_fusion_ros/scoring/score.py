# SPDX-License-Identifier: Apache-2.0
"""The scores of an estimate, of both sensors and of every baseline, at the same stamps."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, baselines_for, methods
from fuzzy_fusion_ros.batch.arrays import Flags, Reals, Stamps, nearest
from fuzzy_fusion_ros.batch.series import Series, Trace, fusion, held_s2, run_economically
from fuzzy_fusion_ros.core.estimator import S2_ONLY, WAITING
from fuzzy_fusion_ros.messages.outputs import DEVIATION, RULES
from fuzzy_fusion_ros.offline.check import check_start
from fuzzy_fusion_ros.offline.recording import Recording, read_explanation, read_recording
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.offline.tracks import Progress, Track
from fuzzy_fusion_ros.offline.truth import suitability
from fuzzy_fusion_ros.online.mode_shares import shares_of
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.scoring.join import gap_time, held, in_gaps, interpolated
from fuzzy_fusion_ros.scoring.metrics import (
    METRICS,
    REPORTED,
    SURENESS,
    Matched,
    ScoreError,
)

Fit = Callable[[Series, Reals, Flags], BaselineParameters]
"""Fits the baselines to a recording, its truth at each S1 sample, and where that counts."""

MOST = 4_000_000
"""Of a longer span every second, third, ... estimate is scored: a day at 1 kHz fits into memory."""

MOST_FITTED = 1_000_000
"""Baselines are fitted to no more samples of S1, from the middle of what is scored."""

_MOSTLY = 0.9

DERIVED = "as the recording suggests them, not fitted"
GIVEN = "as tune has fitted them"
FITTED = "fitted to the span that is scored, which flatters them"
"""Where the parameters of the baselines come from, in words."""


class Score(NamedTuple):
    """The scores of a recording, with everything that tables, JSON and plots show.

    Attributes:
        name: The bag.
        matched: Number n of estimates that could be matched to a truth.
        of: Number of estimates in the span that are scored.
        every: Of this many estimates in the span one is scored; 1 scores all.
        span_s: First and last matched time, seconds from the bag's first message.
        unit: Unit of the signal, ``""`` where it is not known.
        recomputed: Whether the bag had no estimate, so that the fusion ran here.
        baselines: Where the parameters of the baselines come from, in words.
        time_s: Matched times, shape (n,), seconds from the bag's first message.
        truth: The truth at them, shape (n,).
        values: Every estimator's output at them by its name, shape (n,) each.
        deviations: Standard deviation of estimators that report one, by name, shape (n,) each; 0 or
            NaN where unknown.
        behind: What the estimate was made of, where known: weight, drift and the firing strength of
            each rule, by name.
        modes: The share of time in each mode of the fusion with these parameters, by name.
        notes: What was left out of the recording, one line each.
        gap_s: Time in gaps of the truth before each matched time, which metrics leave out, shape
            (n,), seconds.
    """

    name: str
    matched: int
    of: int
    every: int
    span_s: tuple[float, float]
    unit: str
    recomputed: bool
    baselines: str
    time_s: Reals
    truth: Reals
    values: Mapping[str, Reals]
    deviations: Mapping[str, Reals]
    behind: Mapping[str, Reals]
    modes: Mapping[str, float]
    notes: tuple[str, ...]
    gap_s: Reals | float = 0.0

    def scores(
        self, estimator: str, names: Collection[str] = (*METRICS, *SURENESS)
    ) -> dict[str, float]:
        """Return metrics of an estimator by name; those of its deviation only if it reports one.

        Args:
            estimator: Its name.
            names: The metrics to compute.

        Raises:
            ScoreError: There is no such estimator or metric.
        """
        _require("estimator", [estimator], self.values)
        _require("metric", names, (*METRICS, *SURENESS))
        matched = Matched(self.time_s - self.gap_s, self.values[estimator], self.truth)
        found = {name: METRICS[name].function(matched) for name in names if name in METRICS}
        if "sse" in found:
            found["sse"] *= self.every
        unsure = [name for name in names if name in SURENESS]
        if unsure and estimator in self.deviations:
            deviation = self.deviations[estimator]
            rows = (matched.time_s, matched.estimate, matched.truth, deviation)
            sure = Matched(*(each[deviation > 0.0] for each in rows))
            found |= {name: SURENESS[name].function(sure) for name in unsure}
        return found

    @property
    def best_baseline(self) -> str:
        """Name of the baseline, sensors alone included, with the least RMSE: the one to beat."""
        baselines = [name for name in self.values if name in BASELINES]
        return min(baselines, key=lambda name: self.scores(name, ("rmse",))["rmse"])

    def as_json(self) -> dict[str, Any]:
        """Return what ``score --json`` writes; an unknown unit is null."""
        return {
            "matched": self.matched,
            "of": self.of,
            "every": self.every,
            "span_s": list(self.span_s),
            "unit": self.unit or None,
            "best_baseline": self.best_baseline,
            "estimators": {name: self.scores(name, (*REPORTED, *SURENESS)) for name in self.values},
        }


def _require(what: str, names: Collection[str], known: Collection[str]) -> None:
    for name in names:
        if name not in known:
            raise ScoreError(f"there is no {what} {name!r}: expected one of {', '.join(known)}")


def score_bag(
    path: str | Path,
    topics: Topics,
    parameters: Parameters,
    baselines: BaselineParameters | Fit | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
) -> Score:
    """Read a bag and score a span of it; all filters have run from its first message on.

    Args:
        path: The bag.
        topics: What to read of it.
        parameters: Of the fusion, which runs here if the bag has no estimate.
        baselines: Parameters of the baselines, or what fits them to the span that is scored;
            derived from the recording unless given.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.

    Raises:
        BagError: The bag cannot be read, or S1, S2 or the truth is not in it.
        MessageError: A field is not in its type.
        ScoreError: No estimate has a truth at its time.
    """
    with open_bag(path) as bag:
        topics = topics.found_in(bag)
        topics.require_in(bag, "s1", "s2", "truth")
        recording = read_recording(bag, topics, parameters, None, end_s, progress)
        if start_s is not None and _ends_before(recording, start_s):  # time jumped back before
            recording = read_recording(bag, topics, parameters, start_s, end_s, progress)
        if topics.channel:
            recording = _of_channel(recording, topics.channel)
        found = check_start(bag, topics, parameters, start_s, end_s)
        said = suitability(recording, parameters, found, start_s).lines
        recording = recording._replace(notes=(*recording.notes, *said))
        behind = read_explanation(bag, topics, start_s, end_s)
    return score(recording, parameters, baselines, behind, start_s)


def score(
    recording: Recording,
    parameters: Parameters,
    baselines: BaselineParameters | Fit | None = None,
    behind: Mapping[str, Track] | None = None,
    start_s: float | None = None,
) -> Score:
    """Score a recording.

    Args:
        recording: With a truth; without an estimate the fusion runs here.
        parameters: Of the fusion, for that case.
        baselines: Parameters of the baselines, or what fits them to the span that is scored;
            derived from the recording unless given.
        behind: What the bag holds of the estimate's explanation, by name.
        start_s: Where to begin to score, seconds from the bag's first message; what comes before
            only warms the filters up.

    Raises:
        ScoreError: No estimate has a truth at its time.
    """
    estimate, explanation = recording.estimate, dict(behind or {})
    recomputed = estimate.stamps_ns.size == 0
    first, every = _kept(recording, start_s)
    trace = _fused(recording.series, parameters, first, every)
    computed, computed_explanation = _computed(recording, trace)
    computed = computed._replace(values=nearest(computed.values, 0.0, recording.period))
    estimate = (
        computed if recomputed else _at(estimate, computed) if first + every > 1 else estimate
    )
    if _equal(estimate, computed):
        explanation = {**computed_explanation, **explanation}
    estimate = _from(estimate, recording.start_ns, start_s)
    stamps_ns = estimate.stamps_ns
    series = recording.series
    period = recording.period
    truth = interpolated(recording.truth, stamps_ns, period)
    used, origin = _baselines(recording, baselines, stamps_ns[np.isfinite(truth)])
    values = {"estimate": estimate.values}
    deviations = {}
    if DEVIATION in explanation:
        known = explanation.pop(DEVIATION)
        deviations["estimate"] = held(known.stamps_ns, known.values, stamps_ns)
    for name, method in methods(used).items():
        other = _rising(run_economically(method, series, first=first, every=every))
        values[name] = held(other.stamp_ns, other.known(other.value), stamps_ns)
        deviations[name] = held(other.stamp_ns, other.standard_deviation, stamps_ns)
    values = {name: nearest(each, truth, period) for name, each in values.items()}
    usable = np.isfinite([truth, *values.values()]).all(axis=0)
    if not usable.any():
        raise ScoreError(_why_none(recording, estimate))
    matched = {name: each[usable] for name, each in values.items()}
    log_s = (estimate.log_ns[usable] - recording.start_ns) * 1e-9
    since_first = (stamps_ns[usable] - stamps_ns[usable][0]) * 1e-9
    return Score(
        name=recording.name,
        matched=int(usable.sum()),
        of=int(usable.size),
        every=every,
        span_s=(float(log_s[0]), float(log_s[-1])),
        unit=recording.unit,
        recomputed=recomputed,
        baselines=origin,
        time_s=log_s[0] + since_first,
        truth=truth[usable],
        values=matched,
        deviations={
            name: each[usable] for name, each in deviations.items() if (each[usable] > 0.0).any()
        },
        behind={
            name: held(track.stamps_ns, track.values, stamps_ns[usable])
            for name, track in explanation.items()
            if track.stamps_ns.size
        },
        modes=shares_of(trace.mode.tolist(), trace.stamp_ns.tolist()),
        notes=(
            *recording.notes,
            *_thinned(every),
            *_gaps(recording, stamps_ns),
            *_single(matched),
        ),
        gap_s=gap_time(recording.truth.stamps_ns, stamps_ns[usable]),
    )


def _baselines(
    recording: Recording, given: BaselineParameters | Fit | None, matched_ns: Stamps
) -> tuple[BaselineParameters, str]:
    """Return the parameters of the baselines, and where they come from."""
    if isinstance(given, BaselineParameters):
        return given, GIVEN
    series = recording.series
    if given is not None and matched_ns.size:
        begin, end = np.searchsorted(series.s1_ns, [matched_ns[0], matched_ns[-1]]).tolist()
        if end - begin > MOST_FITTED:
            begin = (begin + end - MOST_FITTED) // 2
            series = series.part(begin, begin + MOST_FITTED)
        truth = interpolated(recording.truth, series.s1_ns, recording.period)
        truth = nearest(truth, held_s2(series), recording.period)
        counted = np.isfinite(truth) & (series.s2_known > 0)
        counted &= (series.s1_ns >= matched_ns[0]) & (series.s1_ns <= matched_ns[-1])
        if counted.any():
            return given(series, truth, counted), FITTED
    return baselines_for(series), DERIVED


def _of_channel(recording: Recording, channel: str) -> Recording:
    """Return a recording without estimates that other channels made at stamps of their own.

    A message has S2's value for a channel without an estimate. Estimates none of which is at a
    stamp of the channel are of another program, and are kept.
    """
    series, estimate = recording.series, recording.estimate
    own = _among(estimate.stamps_ns, np.union1d(series.s1_ns, series.s2_ns[series.s2_alone]))
    if own.all() or not own.any():
        return recording
    note = (
        f"{np.sum(~own)} estimates are not scored: channel {channel} has none at their stamps, so "
        "their field is that of S2"
    )
    kept = Track(estimate.stamps_ns[own], estimate.values[own], estimate.log_ns[own])
    return recording._replace(estimate=kept, notes=(*recording.notes, note))


def _ends_before(recording: Recording, start_s: float) -> bool:
    start_ns = recording.start_ns + round(start_s * 1e9)
    return bool((recording.s1.log_ns < start_ns).all())


def _from(track: Track, first_ns: int, start_s: float | None) -> Track:
    """Return what of a track was logged from ``start_s`` on."""
    if start_s is None:
        return track
    kept = track.log_ns >= first_ns + round(start_s * 1e9)
    return Track(track.stamps_ns[kept], track.values[kept], track.log_ns[kept])


def _kept(recording: Recording, start_s: float | None) -> tuple[int, int]:
    """Return the first row of a run that is kept, and of how many from it on one is scored.

    Of no more estimates than ``MOST``, and of estimates at stamps of their own, all are kept.
    """
    series, own_ns = recording.series, recording.estimate.stamps_ns
    rows = series.s1.size + series.s2_alone.size
    if rows <= MOST:
        return 0, 1
    if own_ns.size > 0 and _among(own_ns[:: rows // MOST], series.s1_ns).mean() < _MOSTLY:
        return 0, 1
    first = _first_row(recording, start_s)
    return first, -(-(rows - first) // MOST)


def _first_row(recording: Recording, start_s: float | None) -> int:
    """Return the row of the last sample of S1 that was logged before the span."""
    series = recording.series
    before = recording.s1.stamps_ns.size - _from(recording.s1, recording.start_ns, start_s)[0].size
    if before == 0:
        return 0
    newest_ns = recording.s1.stamps_ns[before - 1]
    k = max(int(np.searchsorted(series.s1_ns, newest_ns, side="right")) - 1, 0)
    return k + int(np.searchsorted(series.s2_alone, series.s2_known[k]))


def _at(estimate: Track, computed: Track) -> Track:
    """Return those estimates of a bag that are at the stamps of computed ones."""
    kept = _among(estimate.stamps_ns, computed.stamps_ns)
    return Track(estimate.stamps_ns[kept], estimate.values[kept], estimate.log_ns[kept])


def _among(stamps_ns: Stamps, of_ns: Stamps) -> Flags:
    """Return which stamps are among others, which rise, shape (n,)."""
    if of_ns.size == 0:
        return np.zeros(stamps_ns.size, dtype=bool)
    after = np.minimum(np.searchsorted(of_ns, stamps_ns), of_ns.size - 1)
    found: Flags = of_ns[after] == stamps_ns
    return found


def _thinned(every: int) -> list[str]:
    return [f"more than {MOST:,} estimates: one in {every} is scored"] if every > 1 else []


def _gaps(recording: Recording, stamps_ns: Stamps) -> list[str]:
    missing = int(np.count_nonzero(in_gaps(recording.truth.stamps_ns, stamps_ns)))
    return [f"{missing} estimates are in gaps of the truth and are not scored"] if missing else []


def _fused(series: Series, parameters: Parameters, first: int, every: int) -> Trace:
    """Return the estimates of the fusion, as a node publishes them; see :func:`run`."""
    method = fusion(parameters, series.started_ns)
    trace = run_economically(method, series, first=first, every=every)
    return _rising(trace.rows(trace.mode != WAITING))


def _single(values: Mapping[str, Reals]) -> list[str]:
    """Say where the estimate is one sensor throughout, digit for digit, and not the other."""
    same = [name for name in ("s1", "s2") if np.array_equal(values["estimate"], values[name])]
    return [
        f"the estimate is {name} alone throughout: the other sensor was never used"
        for name in same
        if len(same) == 1
    ]


def _computed(recording: Recording, trace: Trace) -> tuple[Track, dict[str, Track]]:
    """Return estimates as a track, with their weight, drift and firing strengths."""
    log_ns = np.where(
        trace.mode == S2_ONLY,
        _log_at(recording.s2, trace.stamp_ns),
        _log_at(recording.s1, trace.stamp_ns),
    )

    def track(values: Reals) -> Track:
        return Track(trace.stamp_ns, values, log_ns)

    explanation = {
        "weight": trace.weight,
        "drift": trace.drift,
        DEVIATION: trace.standard_deviation,
        **dict(zip(RULES, trace.strengths.T, strict=True)),
    }
    return track(trace.value), {name: track(each) for name, each in explanation.items()}


def _rising(trace: Trace) -> Trace:
    """Return the rows whose stamps are newer than all before them, as the node publishes them."""
    newest_ns = np.maximum.accumulate(trace.stamp_ns)
    return trace.rows(np.diff(newest_ns, prepend=0) > 0)


def _equal(estimate: Track, computed: Track) -> bool:
    """Return whether the estimates are those of the fusion with these parameters, bit for bit."""
    return np.array_equal(estimate.stamps_ns, computed.stamps_ns) and np.array_equal(
        estimate.values, computed.values
    )


def _log_at(track: Track, stamps_ns: Stamps) -> Stamps:
    """Return when the samples of some stamps were recorded, 0 where there is none."""
    there = _among(stamps_ns, track.stamps_ns)
    logged = np.zeros(stamps_ns.size, dtype=np.int64)
    logged[there] = track.log_ns[np.searchsorted(track.stamps_ns, stamps_ns[there])]
    return logged


def _why_none(recording: Recording, estimate: Track) -> str:
    return (
        f"bag {recording.name!r}: matched 0 of {estimate.stamps_ns.size} estimates: their stamps "
        f"are {_span(estimate)}, those of the truth {_span(recording.truth)}, of S1 "
        f"{_span(recording.s1)}, of S2 {_span(recording.s2)}; where they do not overlap, the "
        "clocks differ (simulated and system time?) or --start and --end leave nothing"
    )


def _span(track: Track) -> str:
    if track.stamps_ns.size == 0:
        return "none"
    return f"{track.stamps_ns[0] * 1e-9:.3f} to {track.stamps_ns[-1] * 1e-9:.3f} s"
