# SPDX-License-Identifier: Apache-2.0
"""The check of two sensors: their characteristics, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, seconds_since
from fuzzy_fusion_ros.batch.bursts import Bursts, bursts_of
from fuzzy_fusion_ros.checking import pair
from fuzzy_fusion_ros.checking.clocks import Clocks, Stamped, judge_clocks
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.motion import Motion, motion_of, parted
from fuzzy_fusion_ros.checking.publishers import judge_publishers
from fuzzy_fusion_ros.checking.relation import MOST_POINTS, Comparison, Kind, Relation
from fuzzy_fusion_ros.checking.samples import SensorSamples, TwoSensors
from fuzzy_fusion_ros.checking.saturation import saturation_of
from fuzzy_fusion_ros.checking.stamps import ClockStep, deliveries, judge_stamps
from fuzzy_fusion_ros.checking.values import Values, judge_values, wrap_of
from fuzzy_fusion_ros.core.numerics import LARGEST
from fuzzy_fusion_ros.online.clocks import duration

FEWEST = 3
"""With fewer usable samples nothing can be said of a sensor."""

GAP_INTERVALS = 10.0
"""A time without samples of more than this many intervals is a gap,"""

GAP_SECONDS = 1.0
"""of more than this many seconds: shorter ones are bridged."""

SHORT, LONG, UNCHANGED = 0.01, 0.1, 0.3
"""Samples less than SHORT seconds apart in bursts that are more than LONG seconds apart are stamped
on receipt, unless values change less within bursts than this share of what they change from one to
the next: the sensor measures several times in a row."""

ABOUT_CLOCKS = frozenset({"clock offset", "clock step"})
"""Findings of :mod:`.clocks` that, as errors, mean two clocks; late delivery does not."""

EXPLAINED = frozenset({"stuck", "wrap", "saturated"})
"""Findings that are to be fixed before sensors can be called unrelated."""


class Character(NamedTuple):
    """What one sensor is like.

    Attributes:
        name: ``s1`` or ``s2``.
        source: Topic, field and, if known, unit.
        samples: How many came.
        usable: How many of them are finite and have a stamp on a lasting timeline.
        interval: Median time between these, seconds; the mean if they come in bursts.
        gap: Longest time between these, seconds.
        delivery: Median time from stamp to arrival, seconds.
        latest: That of the slowest of a hundred, seconds.
        low: Least value.
        high: Largest value.
        noise: Standard deviation of the white noise, as second differences say; too large for a
            sensor that moves much between two samples.
        repeated: Share of samples that equal the one before.
        spikes: Share of samples that jump off and back.
    """

    name: str
    source: str
    samples: int
    usable: int
    interval: float
    gap: float
    delivery: float
    latest: float
    low: float
    high: float
    noise: float
    repeated: float
    spikes: float


class Check(NamedTuple):
    """The result of a check.

    Attributes:
        characters: Characteristics of the sensors by name; one without usable samples is left out.
        behind: How far S2's stamps are behind S1's on arrival, seconds; negative if they are ahead,
            NaN if unknown or if a clock steps.
        relation: How they are related; None if their motion does not show it.
        findings: The findings, worst first.
    """

    characters: dict[str, Character]
    behind: float
    relation: Relation | None
    findings: tuple[Finding, ...]

    @property
    def is_fine(self) -> bool:
        """Whether no problem was found."""
        return all(each.level is Level.INFO for each in self.findings)

    @property
    def clocks_agree(self) -> bool:
        """Whether one clock stamps both sensors, as far as stamps, arrivals and motion show."""
        return not any(
            each.level is Level.ERROR and each.about in ABOUT_CLOCKS for each in self.findings
        )


def check(sensors: TwoSensors, most_points: int = MOST_POINTS) -> Check:
    """Look at two sensors, and say what is wrong.

    Args:
        sensors: Their samples as they came; a node gives its most recent ones.
        most_points: Points to compare motion on; the time that this takes is proportional.
    """
    same = pair.same_source(sensors)
    both = sensors.s1, sensors.s2
    known = pair.period_of(sensors)
    period = known or max(wrap_of(each.values[each.sound]).period for each in both)
    periods = (0.0 if sensors.is_rate else period), period
    judged = [
        _judge(
            each,
            sensors.start_ns,
            own,
            is_known=known > 0.0 or own < period,
            is_rate=sensors.is_rate and each is sensors.s1,
        )
        for each, own in zip(both, periods, strict=True)
    ]
    characters = {each.usable.name: each.character for each in judged if each.character}
    findings = [*same, *pair.same_units(sensors), *pair.wrong_period(sensors)]
    findings += [finding for each in judged for finding in each.findings]
    if len(characters) < 2 or any(each.about == "same topic" for each in same):
        return Check(characters, np.nan, None, _sorted(findings))
    clocks, relation, about_both = _compare(judged[0], judged[1], sensors, most_points, period)
    return Check(characters, clocks.behind, relation, _sorted([*findings, *about_both]))


class _Judged(NamedTuple):
    """One sensor, judged by itself.

    Attributes:
        usable: Its samples with a finite value and a stamp on a lasting timeline.
        steps: Where its clock steps.
        clean: The values of these without wraps and spikes.
        character: What it is like; None if too few samples are usable.
        findings: What is wrong.
    """

    usable: SensorSamples
    steps: tuple[ClockStep, ...]
    clean: Reals
    character: Character | None
    findings: tuple[Finding, ...]


def _judge(
    samples: SensorSamples, start_ns: int, period: float, *, is_known: bool, is_rate: bool
) -> _Judged:
    timeline = judge_stamps(samples, start_ns)
    dated = samples.kept(timeline.usable)
    usable = dated.kept(np.isfinite(dated.values))
    about_samples = (*timeline.findings, *_lacking(samples))
    if usable.values.size < FEWEST:
        count, of = usable.values.size, samples.values.size
        text = (
            f"{count} of {of} samples of {samples.name} can be used, at least {FEWEST} are needed"
        )
        few = Finding(Level.ERROR, "samples", text if of else f"{samples.name} has no messages", {})
        return _Judged(usable, (), usable.values, None, (few, *about_samples))
    largest = float(np.abs(usable.values).max())
    if largest > LARGEST:
        text = f"{samples.name} has values up to {largest:.3g}, whose squares overflow"
        too_large = {"samples": float(np.count_nonzero(np.abs(usable.values) > LARGEST))}
        huge = Finding(Level.ERROR, "overflow", text, too_large, "choose another topic or field")
        return _Judged(usable, (), usable.values, None, (huge, *about_samples))
    values = judge_values(dated, period, is_known=is_known, is_rate=is_rate, start_ns=start_ns)
    publishers = judge_publishers(usable, values.clean)
    gaps = _gaps(samples, start_ns)
    motion = motion_of(seconds_since(int(usable.stamps_ns[0]), usable.stamps_ns), values.clean)
    bursts = bursts_of(motion.time_s)
    shared = publishers or _in_bursts(samples.name, motion.values, bursts)
    findings = (*about_samples, *values.findings, *shared, *gaps)
    character = _character(samples, usable, values, bursts)
    return _Judged(usable, timeline.steps, values.clean, character, findings)


def _character(
    samples: SensorSamples, usable: SensorSamples, values: Values, bursts: Bursts
) -> Character:
    steps = np.diff(np.unique(usable.stamps_ns)) * 1e-9
    delivery = deliveries(usable)
    return Character(
        name=samples.name,
        source=" ".join(filter(None, (samples.topic, samples.field, samples.unit))),
        samples=samples.values.size,
        usable=usable.values.size,
        interval=bursts.interval,
        gap=float(steps.max(initial=0.0)),
        delivery=float(np.median(delivery)),
        latest=float(np.quantile(delivery, 0.99)),
        low=float(usable.values.min()),
        high=float(usable.values.max()),
        noise=values.noise,
        repeated=float(np.mean(np.diff(usable.values) == 0.0)),
        spikes=values.spikes,
    )


def _in_bursts(name: str, values: Reals, bursts: Bursts) -> list[Finding]:
    """Return whether stamps in bursts are those of receipt: within a burst, values change, too."""
    if bursts.size == 1.0 or bursts.within >= SHORT or bursts.period <= LONG:
        return []
    changes = np.abs(np.diff(values))
    within, between = (float(np.median(changes[k])) for k in (~bursts.between, bursts.between))
    if within < UNCHANGED * between:
        return []
    text = (
        f"{name} comes in bursts of about {bursts.size:.2g}, {duration(bursts.period)} apart: it "
        "seems to be stamped on receipt"
    )
    return [Finding(Level.WARNING, "bursts", text, {}, "stamp it when it is measured")]


def _lacking(samples: SensorSamples) -> list[Finding]:
    """Return how many messages lack the number: in some types, that is no fault."""
    if not samples.unreadable:
        return []
    of = samples.unreadable + samples.values.size
    text = (
        f"{samples.unreadable} of {of} messages of {samples.name} have no readable {samples.field}"
    )
    return [Finding(Level.INFO, "samples", text, {})]


def _gaps(samples: SensorSamples, start_ns: int) -> list[Finding]:
    """Return the longest time without samples, by both stamps and arrivals."""
    steps = np.minimum(np.diff(samples.stamps_ns), np.diff(samples.arrivals_ns)) * 1e-9
    if steps.size == 0:
        return []
    usual = bursts_of((samples.arrivals_ns - samples.arrivals_ns[0]) * 1e-9).period
    gaps = np.flatnonzero(steps > max(GAP_INTERVALS * usual, GAP_SECONDS))
    if gaps.size == 0:
        return []
    longest = gaps[np.argmax(steps[gaps])]
    at_s = (int(samples.arrivals_ns[longest]) - start_ns) * 1e-9
    times = "once" if gaps.size == 1 else f"{gaps.size} times"
    text = (
        f"{samples.name} is silent {times}, longest for {duration(steps[longest])} from "
        f"{at_s:.1f} s on; its usual interval is {duration(usual)}"
    )
    return [Finding(Level.WARNING, "gap", text, {})]


def _compare(
    s1: _Judged, s2: _Judged, sensors: TwoSensors, most_points: int, period: float
) -> tuple[Clocks, Relation | None, list[Finding]]:
    """Compare clocks and motion of two sensors."""
    start_ns, kind = sensors.start_ns, pair.kind_by_units(sensors)
    expected = Kind.S1_RATE if sensors.is_rate else Kind.VALUE

    def hypotheses(compared: Comparison) -> list[Relation]:
        return [each for each in compared.relations if kind in {None, each.kind}]

    def on_each(parts: list[tuple[Motion, Motion]]) -> list[list[Relation]]:
        return [hypotheses(Comparison(*part, most_points)) for part in parts]

    def related(s1_s: Reals, s2_s: Reals) -> float | None:
        motions = motion_of(s1_s, s1.clean), motion_of(s2_s, s2.clean)
        return pair.least_cost(hypotheses(Comparison(*motions, most_points)), expected)

    clocks = judge_clocks(
        Stamped(s1.usable, s1.steps), Stamped(s2.usable, s2.steps), start_ns, related
    )
    one, other = motion_of(clocks.s1_s, s1.clean), motion_of(clocks.s2_s, s2.clean)
    at_ends = saturation_of("s1", one, "s2", other), saturation_of("s2", other, "s1", one)
    whole = one, other
    one, other = one.kept(~at_ends[0].clipped), other.kept(~at_ends[1].clipped)
    compared = Comparison(one, other, most_points)
    found = hypotheses(compared)
    findings = [*clocks.findings, *(finding for each in at_ends for finding in each.findings)]
    findings += pair.stuck("s1", one, "s2", other)
    findings += pair.stuck("s2", other, "s1", one)
    about_relation, relation = pair.judge_relation(
        found, expected, s1.usable.scale, only_units=period > 0.0 or kind is not None
    )
    if (
        relation is not None
        and any(each.level > Level.INFO for each in about_relation)
        and not pair.is_lasting(relation, on_each(parted(one, other, 2)))
    ):
        about_relation, relation = [pair.passing(relation)], None
    explained = {each.about for each in (*s1.findings, *s2.findings, *findings)} & EXPLAINED
    if not explained and not pair.is_steady(relation):
        tried = (parted(one, other, parts) for parts in pair.PARTS_COMPARED)
        found_in = (pair.changed(parts, on_each(parts), expected) for parts in tried)
        if changes := next(filter(None, found_in), None):
            about_relation, relation = changes, None
    findings += about_relation
    if relation is not None:
        if any(each.findings for each in at_ends):
            compared = Comparison(*whole, most_points)  # clipping distorts the scale, not the lag
        relation = relation._replace(lag=compared.lag_of(relation))
    if relation is not None and relation.kind is Kind.VALUE:
        findings += pair.exchanged(relation, one, other)
    if relation is not None and not any(each.level for each in findings):
        raw = motion_of(clocks.s2_s, s2.usable.values)
        findings += pair.restless(relation, one, raw, period)
    if relation is None and not about_relation and not explained:
        findings += pair.unrelated(found, one, other, kind or expected)
    return clocks, relation, findings


def _sorted(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Return findings, the worst first; no factor or sign between units that do not go together.

    What units say of a rate counts only if motion does not.
    """
    ordered = sorted(findings, key=lambda each: -each.level)
    by_motion = any(each.about == "rate" and each.evidence for each in ordered)
    needless = {"scale", "sign"} if any(each.about == "units" for each in ordered) else set[str]()
    return tuple(
        each
        for each in ordered
        if (each.about != "rate" or each.evidence or not by_motion) and each.about not in needless
    )
