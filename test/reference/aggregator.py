# SPDX-License-Identifier: Apache-2.0
"""Rate and fuzzy aggregator, in exact fractions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple

SMALL, LARGE = "S", "G"

# (difference, rate) -> (W1, drift)
TABLE_1 = {
    (SMALL, SMALL): ("small", "small"),
    (SMALL, LARGE): ("large", "large"),
    (LARGE, SMALL): ("very_small", "small"),
    (LARGE, LARGE): ("very_large", "small"),
}


class Setting(NamedTuple):
    """Numbers of an aggregator: two ramps (from, to), levels of W1 and of the drift by name."""

    difference: tuple[float, float]
    rate: tuple[float, float]
    weight: Mapping[str, float]
    drift: Mapping[str, float]


PINNED = Setting(
    difference=(0.0, 0.3),
    rate=(0.0, 1.0),
    weight={"very_small": 0.0, "small": 0.05, "large": 0.3, "very_large": 0.7},
    drift={"small": 0.0, "large": 0.1},
)
"""The numbers of the benchmark, with T_r = 0.03 s."""


class Answer(NamedTuple):
    """FA's output, W1, magnitude of the drift, and the firing strengths in Table 1's order."""

    value: Fraction
    weight: Fraction
    drift: Fraction
    strengths: tuple[Fraction, ...]


def rates(
    stamps_ns: Sequence[int],
    values: Sequence[float],
    time_constant: float,
    longest_gap: float = float("inf"),
) -> list[Fraction]:
    """Return dS2/dt after each sample; a gap starts anew, with a rate of 0."""
    found: list[Fraction] = []
    for k, stamp_ns in enumerate(stamps_ns):
        dt = Fraction(stamp_ns - stamps_ns[k - 1], 10**9)
        if k == 0 or dt > longest_gap:
            found.append(Fraction(0))
            continue
        step = Fraction(values[k]) - Fraction(values[k - 1])
        smoothing = Fraction(time_constant)
        found.append((smoothing * found[-1] + step) / (smoothing + dt))
    return found


def grades(x: Fraction, ramp: tuple[float, float]) -> dict[str, Fraction]:
    """Return the grades of *small* and *large*, of which the latter rises along the ramp."""
    start, end = Fraction(ramp[0]), Fraction(ramp[1])
    if x <= start:
        grade = Fraction(0)
    elif x >= end:
        grade = Fraction(1)
    else:
        grade = (x - start) / (end - start)
    return {SMALL: 1 - grade, LARGE: grade}


def aggregate(setting: Setting, s1: float, s2: float, rate: float | Fraction) -> Answer:
    """Return what FA says."""
    first, second, slope = Fraction(s1), Fraction(s2), Fraction(rate)
    d = grades(abs(first - second), setting.difference)
    r = grades(abs(slope), setting.rate)
    strengths = {rule: d[rule[0]] * r[rule[1]] for rule in TABLE_1}
    total = sum(strengths.values())
    assert total == 1
    weight = sum(
        strength * Fraction(setting.weight[TABLE_1[rule][0]])
        for rule, strength in strengths.items()
    )
    drift = sum(
        strength * Fraction(setting.drift[TABLE_1[rule][1]]) for rule, strength in strengths.items()
    )
    direction = (slope > 0) - (slope < 0)
    return Answer(
        value=weight * first + (1 - weight) * second + direction * drift,
        weight=Fraction(weight),
        drift=Fraction(drift),
        strengths=tuple(strengths.values()),
    )


def aggregated(
    setting: Setting,
    time_constant: float,
    s1: Sequence[tuple[int, float]],
    s2: Sequence[tuple[int, float]],
) -> list[Answer]:
    """Return what FA says at every S1 sample; S2 is held from the moment of its stamp on.

    Args:
        setting: Of the aggregator.
        time_constant: T_r, seconds.
        s1: Stamps in nanoseconds and values of S1.
        s2: Those of S2, the first of them no later than S1's first.
    """
    slopes = rates([stamp for stamp, _ in s2], [value for _, value in s2], time_constant)
    answers = []
    for stamp, value in s1:
        newest = max(k for k, (stamp_2, _) in enumerate(s2) if stamp_2 <= stamp)
        answers.append(aggregate(setting, value, s2[newest][1], slopes[newest]))
    return answers
