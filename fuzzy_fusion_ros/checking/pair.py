# SPDX-License-Identifier: Apache-2.0
"""What is wrong between two sensors: sign, scale, rate for value, swapped, stuck, unrelated."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from fuzzy_fusion_ros.batch.arrays import Reals, nearest, white_noise
from fuzzy_fusion_ros.checking.finding import Finding, Level
from fuzzy_fusion_ros.checking.motion import Motion
from fuzzy_fusion_ros.checking.relation import NEAR_ONE, Conversion, Kind, Relation
from fuzzy_fusion_ros.checking.samples import TwoSensors
from fuzzy_fusion_ros.messages.units import INTEGRALS, RATES, TURNS, unit_of_s1

MARGIN = 1.5
"""Evidence by which a fault must be more credible than sensors as they should be: 4.5 to 1."""

RELATED = 0.8
"""From this correlation on, motion is common, whatever chance would give."""

ABOVE_CHANCE = 5.0
"""Below it, the correlation must be this many times that of lags far off,"""

LEAST = 0.3
"""and at least this."""

CREDIBLE = (0.6, 3.0)
"""A fault of sign, scale or kind is named only from this correlation on that is this many times
chance,"""

BEYOND_DOUBT = 0.95
"""or from this one on: that of a sine and its rate is not above chance, but no chance either."""

FACTOR = 1.8
"""A scale off by less is the inaccuracy of a sensor rather than another unit. What is unexplained
counts twice, as noise and as dynamics: a slow sensor does not reach the peaks."""

PARTS_COMPARED = (4, 8)
"""Equal parts of a recording that are searched for a change of sign or scale: few have more motion
each, many show a change near the end."""

SHOW_ONE = 0.6
"""Of these parts, at least this share shows a relation beyond doubt: few may match by chance."""

CHANGED = 2.5
"""The scale changes by at least this factor. A slow sensor follows fast motion less than slow."""

SAME_LAG = 0.25
"""Over such a change, the lag stays within this many seconds and an interval of S2. Where two sines
drift apart, it does not."""

SAME_CURVE = 2.0
"""Nor has it changed if S1 scatters about one curve over S2 with less than this many times the
variance with which it scatters about one before and one after: then it bends."""

UNRELATED = 2.5
"""Sensors have nothing in common if no hypothesis reaches this many times chance,"""

ENOUGH = 60
"""in a recording of at least this many intervals of the slower one."""

WHITE = 0.5
"""Correlation of a sample with the next below which a sensor shows nothing but noise."""

MOVES = 2.5
"""A sensor moves if over some time the mean square of its changes is this many times that over half
of it: 4 for smooth motion, at most 2 for a walk and for noise behind a lag, 1 for white noise."""

PARTS = 20
"""Changes are taken over at most this part of a recording for that."""

FASTER = 2.0
"""S2 is the faster sensor if it has this many times S1's rate."""

MUCH_FASTER = 5.0
"""From this many times on, that is enough to take S2 for S1, unless it lags behind S1."""

NOISIER = 3.0
"""S2 is the noisier sensor if it has this many times S1's noise."""

LEAD = 0.05
"""S2 is ahead of S1 from this many seconds on, or a quarter of the longer interval."""

USUAL, WILD = 0.95, 10.0
"""While S1 moves, this share of the steps of S2 is off by less than usual; a step that is off by
this many times as much is wild."""

AT_REST = (10, 0.02, 0.1)
"""S2 scatters at rest if there are this many wild steps and this share then, and less than this
share of them in motion,"""

TURNS_AT_REST = 0.25
"""and more than this share of those in a row are opposite: what S1 misses moves one way."""

STUCK_FOR = (1.0, 5.0, 20)
"""A sensor is stuck if it does not change for this many seconds, this many intervals of the slower
sensor, and this many of its own samples, while the other moves:"""

OTHER_MOVES = (1.0, 2.0)
"""over this many of its standard deviations, with this many times that of its noise."""

COPIED = 0.99
"""Share of the samples of one sensor from which on it is a copy, if the other has them too."""

MOST_PERIODS = 8
"""In a turn: lines have two periods, the edges of a square four."""

WHOLE = 0.01
"""A period divides a turn if their ratio is this close to a whole number: 3.14 is meant as pi."""

EXCHANGE_RATE = "swap --s1 and --s2, and set s1.kind: rate"


def same_source(sensors: TwoSensors) -> list[Finding]:
    """Judge whether both sensors are one."""
    s1, s2 = sensors.s1, sensors.s2
    if s1.topic and (s1.topic, s1.field) == (s2.topic, s2.field):
        text = f"s1 and s2 are both {s1.topic} {s1.field}".rstrip()
        return [
            Finding(Level.ERROR, "same topic", text, {}, "set --s1 and --s2 to different sensors")
        ]
    fewer, more = sorted((s2, s1), key=lambda each: each.values.size)
    if fewer.values.size == 0 or fewer.values.min() == fewer.values.max():
        return []
    order = np.argsort(more.stamps_ns, kind="stable")
    place = np.searchsorted(more.stamps_ns[order], fewer.stamps_ns)
    place = order[np.minimum(place, order.size - 1)]
    equal = (more.stamps_ns[place] == fewer.stamps_ns) & (more.values[place] == fewer.values)
    if np.mean(equal) < COPIED:
        return []
    text = f"{fewer.name} is a copy of {more.name}: every stamp and value of it is also there"
    return [Finding(Level.WARNING, "copy", text, {}, "set --s1 and --s2 to different sensors")]


def same_units(sensors: TwoSensors) -> list[Finding]:
    """Judge whether the units of both sensors, where known, are one."""
    s1, s2 = sensors.s1.unit, sensors.s2.unit
    if not (s1 and s2) or s1 == unit_of_s1(s2, sensors.is_rate):
        return []
    text = f"s1 is in {s1}, s2 in {s2}"
    remedy = {Kind.S1_RATE: "s1.kind: rate", Kind.S2_RATE: EXCHANGE_RATE}
    kind = kind_by_units(sensors)
    if kind is Kind.VALUE:
        text = f"s1 and s2 are in {s1}, but s1.kind is rate"
        return [Finding(Level.ERROR, "rate", text, {}, "s1.kind: value")]
    if kind in remedy:
        return [
            Finding(Level.ERROR, "rate", f"{text}: one is the rate of the other", {}, remedy[kind])
        ]
    return [Finding(Level.ERROR, "units", text, {}, "choose another topic or field")]


def wrong_period(sensors: TwoSensors) -> list[Finding]:
    """Judge whether ``signal.period``, if set, divides a turn in a known unit of the signal."""
    turn = period_of(sensors)
    name, unit = _angle(sensors)
    if sensors.period > 0.0 and sensors.s2.unit and not unit:
        text = f"signal.period is for angles, but s2 is in {sensors.s2.unit}"
        return [Finding(Level.WARNING, "period", text, {}, "signal.period: 0.0")]
    if turn == sensors.period:
        return []
    text = (
        f"signal.period is {sensors.period:.10g}, but {name} is in {unit}, "
        f"where a turn is {turn:.16g}"
    )
    return [Finding(Level.WARNING, "period", text, {}, f"signal.period: {turn:.16g}")]


def period_of(sensors: TwoSensors) -> float:
    """Return the period by which the samples wrap: ``signal.period`` unless that is wrong."""
    _, unit = _angle(sensors)
    if sensors.period == 0.0 or not unit:
        return sensors.period
    turn = TURNS[unit]
    periods = turn / sensors.period
    whole = min(max(round(periods), 1), MOST_PERIODS)
    return sensors.period if abs(periods - whole) < WHOLE else turn


def _angle(sensors: TwoSensors) -> tuple[str, str]:
    """Return what is known to be an angle or the rate of one, and its unit, or two empty texts."""
    named = {"the signal": sensors.unit, "s2": sensors.s2.unit, "s1": sensors.s1.unit}
    return next(((name, unit) for name, unit in named.items() if unit in TURNS), ("", ""))


def kind_by_units(sensors: TwoSensors) -> Kind | None:
    """Return what the units of the sensors say that they are to each other; None if nothing."""
    s1, s2 = sensors.s1.unit, sensors.s2.unit
    if not (s1 and s2):
        return None
    kinds = {s2: Kind.VALUE, RATES.get(s2): Kind.S1_RATE, INTEGRALS.get(s2): Kind.S2_RATE}
    return kinds.get(s1)


def is_related(relation: Relation) -> bool:
    """Return whether a relation is more than chance."""
    r = relation.correlation
    return r >= RELATED or (r >= LEAST and r >= ABOVE_CHANCE * relation.chance)


def is_credible(relation: Relation) -> bool:
    """Return whether a relation is so far beyond chance that it may be a fault."""
    r = relation.correlation
    return r >= BEYOND_DOUBT or r >= max(CREDIBLE[0], CREDIBLE[1] * relation.chance)


def judge_relation(
    found: Sequence[Relation],
    expected: Kind = Kind.VALUE,
    scale: float = 1.0,
    *,
    only_units: bool = False,
) -> tuple[list[Finding], Relation | None]:
    """Judge what the sensors are to each other.

    Args:
        found: The hypotheses, the most credible first.
        expected: What the parameters say that they are.
        scale: What ``s1.scale`` is; a fix multiplies it.
        only_units: Whether no factor counts but one between units: where the types state units, and
            for angles, whose whole turns add up to a factor of their own.

    Returns:
        What is wrong, and the relation to believe in; None if the motion does not show it.
    """
    if not found or not is_related(found[0]):
        return [], None
    best = found[0]
    plain = next((each for each in found if _is_as_it_should(each, expected)), None)
    if best is plain or not is_credible(best):
        return (_scale(best, scale, only_units), best) if best is plain else ([], None)
    margin = np.inf if plain is None else plain.cost - best.cost
    if margin < MARGIN:
        return [_ambiguous(best, plain)], plain
    return [_odd(best, plain, expected, scale, only_units)], best


def least_cost(found: Sequence[Relation], expected: Kind) -> float | None:
    """Return what the most credible hypothesis costs, a fault by its margin more.

    Args:
        found: The hypotheses, the most credible first.
        expected: What the parameters say that the sensors are to each other.

    Returns:
        ``None`` if the motion shows no relation.
    """
    if not found or not is_related(found[0]):
        return None
    return min(
        each.cost + (0.0 if _is_as_it_should(each, expected) else MARGIN)
        for each in found
        if is_related(each)
    )


def is_lasting(relation: Relation, halves: Iterable[Sequence[Relation]]) -> bool:
    """Return whether the halves of a recording bear out the fault that the whole seems to have.

    They do if one shows it beyond chance or both show it, unless another relation is more credible
    in one of them. A half at rest, or one in which noise hides the motion, is no evidence against a
    fault.

    Args:
        relation: How the sensors are related over the whole recording, which is a fault.
        halves: The hypotheses on each half, the most credible first; those of too few samples,
            which have none, do not count.
    """
    compared = [half for half in halves if half]
    same = [
        next((each for each in half if _may_be_same(each, relation)), None) for half in compared
    ]
    for half, each in zip(compared, same, strict=True):
        margin = np.inf if each is None else each.cost - half[0].cost
        if is_related(half[0]) and margin >= MARGIN:
            return False
    seen = [each for each in same if each is not None and is_related(each)]
    return len(seen) == len(compared) or any(map(is_credible, seen))


def _may_be_same(one: Relation, other: Relation) -> bool:
    """Return whether two relations may be the same: in kind, sign and scale."""
    if (one.kind, one.sign) != (other.kind, other.sign):
        return False
    ratio = one.middle_scale / other.middle_scale
    overlap = min(one.scale[1], other.scale[1]) / max(one.scale[0], other.scale[0])
    return 1.0 / FACTOR < ratio < FACTOR or overlap >= 1.0 / NEAR_ONE


def is_steady(relation: Relation | None) -> bool:
    """Return whether the whole recording shows one relation too well for it to have changed."""
    return relation is not None and relation.correlation >= BEYOND_DOUBT


def changed(
    parts: Sequence[tuple[Motion, Motion]],
    found: Sequence[Sequence[Relation]],
    expected: Kind,
) -> list[Finding]:
    """Judge whether sign or scale changes once in a recording.

    Args:
        parts: S1 and S2 in parts of it, in order.
        found: The hypotheses on each part, the most credible first.
        expected: What the parameters say that the sensors are to each other.
    """
    seen = [
        (part, each[0])
        for part, each in zip(parts, found, strict=True)
        if each and each[0].kind is expected and _is_beyond_doubt(each)
    ]
    differs = [k for k in range(1, len(seen)) if not _may_be_same(seen[k][1], seen[k - 1][1])]
    if len(differs) != 1 or len(seen) < SHOW_ONE * len(parts):
        return []
    early, late = seen[: differs[0]], seen[differs[0] :]
    before, after = (max((each for _, each in side), key=_correlation) for side in (early, late))
    if abs(after.lag - before.lag) > SAME_LAG + parts[0][1].interval:
        return []
    by = abs(np.log(after.middle_scale / before.middle_scale))
    if before.sign == after.sign and by < np.log(CHANGED):
        return []
    if expected is Kind.VALUE and _is_one_curve(*(_on_curve(side) for side in (early, late))):
        return []
    until = f"until {float(early[-1][0][1].time_s[-1]):.1f} s"
    since = f"from {float(late[0][0][1].time_s[0]):.1f} s on"
    if before.sign == after.sign:
        read, reads = (each.sign / each.middle_scale for each in (before, after))
        text = f"s1 reads {read:.2g} times what s2 reads {until} and {reads:.2g} times {since}"
    else:
        signs = ("the sign", "the opposite")[:: before.sign]
        text = f"s1 has {signs[0]} of s2 {until} and {signs[1]} {since}"
    evidence = {
        "correlation before": before.sign * before.correlation,
        "correlation after": after.sign * after.correlation,
    }
    remedy = "find out what changed there, or choose a part by --start and --end"
    return [Finding(Level.WARNING, "changed", text, evidence, remedy)]


def _correlation(relation: Relation) -> float:
    return relation.correlation


def _on_curve(parts: Sequence[tuple[tuple[Motion, Motion], Relation]]) -> Reals:
    """Return S2 and what S1 read a lag before, shape (2, n)."""
    rows = [
        (s2.values, np.interp(s2.time_s - relation.lag, s1.time_s, s1.values))
        for (s1, s2), relation in parts
    ]
    return np.concatenate(rows, axis=1)


def _is_one_curve(early: Reals, late: Reals) -> bool:
    """Return whether S1 is the same function of S2 in both, over what S2 has in common."""
    both = early, late
    low, high = max(each[0].min() for each in both), min(each[0].max() for each in both)
    common = [each[:, (each[0] >= low) & (each[0] <= high)] for each in both]
    apart = sum(_scatter(each) for each in common)
    return _scatter(np.concatenate(common, axis=1)) <= SAME_CURVE * apart


def _scatter(points: Reals) -> float:
    """Return the sum of squares from each point to the next along a curve."""
    return float(np.sum(np.diff(points[1, np.argsort(points[0])]) ** 2))


def _is_beyond_doubt(found: Sequence[Relation]) -> bool:
    """Return whether a part shows the best hypothesis on it beyond doubt."""
    rival = min((each.cost for each in found[1:]), default=np.inf)
    return found[0].correlation >= BEYOND_DOUBT and rival - found[0].cost >= MARGIN


def passing(relation: Relation) -> Finding:
    """Return the finding that the halves do not bear out a relation that would be a fault."""
    text = "the relation between s1 and s2 over the whole recording does not hold in each half"
    evidence = {"correlation": relation.sign * relation.correlation}
    return Finding(Level.INFO, "ambiguous", text, evidence, "record more varied motion")


def _is_as_it_should(relation: Relation, expected: Kind) -> bool:
    return relation.kind is expected and relation.sign > 0


def _odd(
    best: Relation, plain: Relation | None, expected: Kind, scale: float, only_units: bool
) -> Finding:
    """Return the finding that a relation is not the plain one."""
    evidence = {"correlation": best.sign * best.correlation}
    is_expected = best.kind is expected
    if plain is not None and not is_expected:
        evidence["as values"] = plain.correlation
    # Noise adds up in an integral.
    factor, units = factor_of(best, only_units=only_units or not is_expected)
    size = "" if factor == 1.0 else f", times {1.0 / factor:.3g}{units}"
    negated = "the negated " if best.sign < 0 else "the "
    change = best.sign * factor
    rescaled = [] if change == 1.0 else [f"s1.scale: {change * scale:.7g}"]
    if best.kind is Kind.S1_RATE and not is_expected:
        text = f"s1 is {negated}rate of s2{size}"
        remedy = " and ".join(["s1.kind: rate", *rescaled])
        return Finding(Level.ERROR, "rate", text, evidence, remedy)
    if best.kind is Kind.S2_RATE:
        text = f"s2 is {negated}rate of s1"
        return Finding(Level.ERROR, "rate", text, evidence, EXCHANGE_RATE)
    if best.kind is Kind.VALUE and not is_expected:
        text = f"s1 is not the rate of s2 but {negated}same quantity{size}"
        return Finding(Level.ERROR, "rate", text, evidence, "s1.kind: value")
    text = f"s1 has the opposite sign of s2{size}"
    return Finding(Level.ERROR, "sign", text, evidence, *rescaled)


def _scale(relation: Relation, scale: float, only_units: bool) -> list[Finding]:
    """Return whether the scale of plain values is another unit's."""
    factor, units = factor_of(relation, only_units=only_units)
    if factor == 1.0 or not is_credible(relation):
        return []
    evidence = {"ratio": 1.0 / relation.middle_scale, "correlation": relation.correlation}
    text = f"s1 reads {1.0 / factor:.3g} times what s2 reads{units}"
    return [Finding(Level.ERROR, "scale", text, evidence, f"s1.scale: {factor * scale:.7g}")]


def conversion_of(relation: Relation) -> float:
    """Return the signed factor from the unit of S1 to that of S2, 1 unless units differ."""
    return relation.sign * factor_of(relation, only_units=True)[0]


def factor_of(relation: Relation, *, only_units: bool) -> tuple[float, str]:
    """Return the factor from S1 to S2, 1 if it may be that, and which units it is for.

    Args:
        relation: What they are to each other.
        only_units: As in :func:`judge_relation`.
    """
    low, high = relation.scale[0] * relation.correlation, relation.scale[1] / relation.correlation
    if low <= FACTOR and high >= 1.0 / FACTOR:
        return 1.0, ""
    if not relation.conversions:
        return (1.0 if only_units else float(f"{relation.middle_scale:.2g}")), ""
    (units, factor), *others = relation.conversions
    or_else = "".join(f", or {_against(each, to)}, {1.0 / to:.3g} times" for each, to in others)
    return factor, f": {_against(units, factor)}{or_else}"


def _against(units: Conversion, factor: float) -> str:
    """Return the units of S1 and S2 between which a factor converts."""
    names = (units.smaller, units.larger) if factor < 1.0 else (units.larger, units.smaller)
    return " against ".join(names)


def _ambiguous(best: Relation, plain: Relation | None) -> Finding:
    what = {
        Kind.VALUE: "s1 may have the opposite sign of s2",
        Kind.S1_RATE: "s1 may be the rate of s2",
        Kind.S2_RATE: "s2 may be the rate of s1",
    }[best.kind]
    evidence = {"correlation": best.sign * best.correlation}
    if plain is not None:
        evidence["as they are"] = plain.correlation
    text = f"{what}; in this motion both look much the same"
    return Finding(Level.INFO, "ambiguous", text, evidence, "record more varied motion")


def unrelated(
    found: Sequence[Relation], s1: Motion, s2: Motion, by_units: Kind | None
) -> list[Finding]:
    """Judge whether the sensors have nothing in common.

    Args:
        found: All hypotheses. One that :func:`is_related` is too little to name it, but too much
            for chance.
        s1: Motion of S1.
        s2: Motion of S2.
        by_units: What their units say that they are: a rate is believed, as its integral drifts.
    """
    text = "s1 and s2 share too little motion to be compared"
    if not found:
        return [Finding(Level.INFO, "motion", text, {})]
    best = max(found, key=lambda each: each.correlation)
    moves = (_moves(s1) or _moves(s2)) and not (_is_white(s1) or _is_white(s2))
    enough = min(s1.intervals, s2.intervals) >= ENOUGH and moves
    enough = enough and not any(is_related(each) for each in found)
    if not enough or by_units is Kind.S1_RATE or best.correlation > UNRELATED * best.chance:
        return [Finding(Level.INFO, "motion", text, {"correlation": best.correlation})]
    evidence = {
        "correlation": best.correlation,
        "up to by chance": min(1.0, UNRELATED * best.chance),
    }
    text = "s1 and s2 are correlated no better than by chance"
    return [Finding(Level.WARNING, "unrelated", text, evidence, "choose another topic or field")]


def _moves(motion: Motion) -> bool:
    spans = 2 ** np.arange(max(1, int(np.log2(max(2.0, motion.intervals / PARTS))) + 1))
    changes = [float(np.mean((motion.values[k:] - motion.values[:-k]) ** 2)) for k in spans]
    return any(after > MOVES * before for before, after in pairwise(changes))


def _is_white(motion: Motion) -> bool:
    spread = float(np.var(motion.values))
    step = float(np.mean(np.diff(motion.values) ** 2))
    return step >= 2.0 * (1.0 - WHITE) * spread


def exchanged(relation: Relation, s1: Motion, s2: Motion) -> list[Finding]:
    """Judge whether S1 and S2 have each other's role.

    Args:
        relation: What they are to each other, plain or negated.
        s1: Motion of S1.
        s2: Motion of S2.
    """
    faster = s1.interval / s2.interval
    noisier = _ratio(white_noise(s2.values), relation.middle_scale * white_noise(s1.values))
    least = max(LEAD, 0.25 * max(s1.interval, s2.interval))
    ahead = -relation.lag > least
    behind = relation.lag > least
    signs = {"faster": faster >= FASTER, "noisier": noisier >= NOISIER, "ahead of s1": ahead}
    seen = [name for name, is_seen in signs.items() if is_seen]
    if len(seen) + (faster >= MUCH_FASTER) - behind < 2 or faster < 1.0 / FASTER:
        return []
    text = f"s1 and s2 look swapped: s2 is {' and '.join(seen)}"
    evidence = {"rate": faster, "noise": noisier, "lag": relation.lag}
    return [Finding(Level.WARNING, "exchanged", text, evidence, "swap --s1 and --s2")]


def restless(relation: Relation, s1: Motion, s2: Motion, period: float) -> list[Finding]:
    """Judge whether S2 means nothing while S1 rests, as the course of a GNSS receiver.

    Args:
        relation: What they are to each other, which is as it should be.
        s1: Motion of S1.
        s2: Motion of S2, wraps and spikes included.
        period: Where it wraps, unit of the signal; 0 if it does not.
    """
    s1_values = s1.values
    if relation.kind is Kind.S1_RATE:
        steps = np.diff(s1.time_s) * 0.5 * (s1_values[1:] + s1_values[:-1])
        s1_values = np.append(0.0, np.cumsum(steps))
    expected = np.diff(np.interp(s2.time_s - relation.lag, s1.time_s, s1_values))
    off = nearest(np.diff(s2.values) - expected, 0.0, period)
    moving = np.abs(expected) > np.median(np.abs(expected))
    if not moving.any():
        return []
    usual = float(np.quantile(np.abs(off[moving]), USUAL))
    wild = np.abs(off) > WILD * usual
    at_rest = wild & ~moving
    in_a_row = at_rest[1:] & at_rest[:-1]
    turns = in_a_row & (off[1:] * off[:-1] < 0.0)
    count = np.count_nonzero(at_rest)
    is_random = np.count_nonzero(turns) > TURNS_AT_REST * np.count_nonzero(in_a_row)
    only_at_rest = np.count_nonzero(wild & moving) < AT_REST[2] * count
    if count < max(AT_REST[0], AT_REST[1] * off.size) or not (is_random and only_at_rest):
        return []
    text = (
        f"s2 scatters while s1 rests: {count} of its {off.size} steps are off by "
        f"{float(np.median(np.abs(off[at_rest]))):.2g} (median), in motion they are by up to "
        f"{usual:.2g}"
    )
    remedy = (
        "let its driver withhold it at rest, or else set s2.outlier_threshold: 4, which helps less "
        "and needs s1.bias_time_constant > 0: tune fits both"
    )
    return [Finding(Level.INFO, "restless", text, {}, remedy)]


def _ratio(one: float, other: float) -> float:
    return one / other if other > 0.0 else np.inf


def stuck(name: str, motion: Motion, other_name: str, other: Motion) -> list[Finding]:
    """Judge whether a sensor stands still while the other moves.

    Args:
        name: The sensor.
        motion: Its motion, spikes included.
        other_name: The other sensor.
        other: Its motion.
    """
    first, last = _longest_rest(motion.values)
    begin, end = float(motion.time_s[first]), float(motion.time_s[last])
    seconds, intervals, samples = STUCK_FOR
    slower = max(motion.interval, other.interval)
    if last - first + 1 < samples or end - begin < max(seconds, intervals * slower):
        return []
    during = other.values[(other.time_s >= begin) & (other.time_s <= end)]
    if during.size < intervals:
        return []
    low, high = np.quantile(during, [0.05, 0.95])
    moved = float(high - low)
    noise = white_noise(other.values)
    spread, share = float(np.std(other.values)), float(np.std(during))
    if moved == 0.0 or moved < OTHER_MOVES[0] * spread or share < OTHER_MOVES[1] * noise:
        return []
    whole = last - first + 1 == motion.values.size
    when = "throughout" if whole else f"from {begin:.1f} s to {end:.1f} s"
    text = (
        f"{name} is stuck: it reads {motion.values[first]:.4g} {when} while {other_name} moves "
        f"over {moved:.3g}"
    )
    level = Level.ERROR if whole else Level.WARNING
    evidence = {f"noise of {other_name}": noise}
    return [Finding(level, "stuck", text, evidence, "check the sensor and its driver")]


def _longest_rest(values: Reals) -> tuple[int, int]:
    """Return first and last place of the longest run of equal values."""
    changes = np.flatnonzero(np.diff(values) != 0.0)
    firsts = np.append(0, changes + 1)
    lasts = np.append(changes, values.size - 1)
    longest = int(np.argmax(lasts - firsts))
    return int(firsts[longest]), int(lasts[longest])
