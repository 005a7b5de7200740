# SPDX-License-Identifier: Apache-2.0
"""How often a check is right, over made-up sensors of many kinds; docs/check.md has more seeds."""

from __future__ import annotations

import pytest
from checking.rates import EXPECTED, rates
from checking.standins import FAULTS, MOTIONS

SEEDS = range(3)
PAIRS = len(SEEDS) * len(MOTIONS)

MOTION = len(SEEDS)
"""Pairs of one motion."""

# How many pairs must be named right, and how many may be blamed for something else.
ALMOST_ALWAYS = (PAIRS - 1, 0)
ONE_MOTION_HIDES_IT = (PAIRS - MOTION, 0)
BOUNDS = {
    "none": (PAIRS, 0),
    # 10 would be named if a half in which noise hides the motion spoke against the fault, and 15
    # are, as it does not; over the 140 pairs of docs/check.md half are.
    "negated, noise in one half": (12, 0),
    # The rate of a sine is a sine, that of steps is next to nothing between them.
    "s1 is the rate": ONE_MOTION_HIDES_IT,
    "s2 is the rate": (PAIRS - 2 * MOTION, 1),
    # Where little moves, there is little to compare.
    "exchanged": ONE_MOTION_HIDES_IT,
    "s1 stuck": ONE_MOTION_HIDES_IT,
    "s1 stuck in the second half": ONE_MOTION_HIDES_IT,
    # Two slow motions can match by chance; one pair in ten then matches through a sign or a rate.
    "unrelated": (PAIRS // 2 + 1, PAIRS // 10),
}


def test_every_fault_has_an_expectation() -> None:
    assert set(EXPECTED) == set(FAULTS)


LIKE_ANOTHER = {
    "scale 1/57.3",
    "scale 9.81",
    "scale 3.6",
    "scale 1/100",
    "s2 1.5 s ahead",
    "s2 from boot",
    "10 % spikes",
}


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(each, marks=pytest.mark.slow("as another scale, offset, share"))
        if each in LIKE_ANOTHER
        else each
        for each in FAULTS
    ],
)
def test_faults_are_named_and_nothing_else(fault: str) -> None:
    named, misled = BOUNDS.get(fault, ALMOST_ALWAYS)
    found = rates(fault, SEEDS)
    assert found.pairs == PAIRS
    assert found.named >= named, found
    assert found.misled <= misled, found
