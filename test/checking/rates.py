# SPDX-License-Identifier: Apache-2.0
"""How often a check names what is wrong with made-up sensors, and how often it is wrong itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from checking.standins import MOTIONS, pair

from fuzzy_fusion_ros.checking.check import check
from fuzzy_fusion_ros.checking.finding import Level

EXPECTED: Mapping[str, frozenset[str]] = {
    "none": frozenset(),
    "negated": frozenset({"sign"}),
    "negated, noise in one half": frozenset({"sign"}),
    "scale 57.3": frozenset({"scale"}),
    "scale 1/57.3": frozenset({"scale"}),
    "scale 9.81": frozenset({"scale"}),
    "scale 3.6": frozenset({"scale"}),
    "scale 1/100": frozenset({"scale"}),
    "scale 5": frozenset({"scale"}),
    "s1 is the rate": frozenset({"rate"}),
    "s2 is the rate": frozenset({"rate"}),
    "s2 5 s behind": frozenset({"clock offset"}),
    "s2 1.5 s ahead": frozenset({"clock offset"}),
    "s2 from boot": frozenset({"clock offset"}),
    "s1 restarts at 0": frozenset({"clock step", "clock offset"}),
    "s2 0.8 s late": frozenset(),
    "exchanged": frozenset({"exchanged"}),
    "s1 stuck": frozenset({"stuck"}),
    "s2 stuck": frozenset({"stuck"}),
    "s1 stuck in the second half": frozenset({"stuck"}),
    "2 % spikes": frozenset({"spikes"}),
    "10 % spikes": frozenset({"spikes"}),
    "unrelated": frozenset({"unrelated"}),
}
"""What a check has to warn of, by fault; late delivery is told, but is no fault."""

POINTS = 2048
"""As few as the live node compares."""


class Rates(NamedTuple):
    """How often a check was right about a fault.

    Attributes:
        pairs: Pairs of sensors that have it.
        named: Pairs in which all that is wrong was named, and nothing else.
        silent: Pairs in which nothing was said to be wrong.
        misled: Pairs in which something that is not wrong was said to be.
    """

    pairs: int
    named: int
    silent: int
    misled: int


def rates(fault: str, seeds: Iterable[int]) -> Rates:
    """Check pairs of sensors of every motion that have a fault."""
    expected = EXPECTED[fault]
    found = [warned(motion, fault, seed) for seed in seeds for motion in MOTIONS]
    return Rates(
        pairs=len(found),
        named=sum(each == expected for each in found),
        silent=sum(not each for each in found),
        misled=sum(bool(each - expected) for each in found),
    )


def warned(motion: str, fault: str, seed: int) -> frozenset[str]:
    """Return what a check of one pair warns of."""
    findings = check(pair(motion, fault, seed).sensors(), POINTS).findings
    return frozenset(each.about for each in findings if each.level > Level.INFO)
