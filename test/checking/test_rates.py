# SPDX-License-Identifier: Apache-2.0
"""How often a check is right, over made-up sensors of many kinds; docs/check.md has more seeds."""

from __future__ import annotations

import pytest
from checking.rates import EXPECTED, rates
from checking.standins import FAULTS, MOTIONS

SEEDS = range(3)
PAIRS = len(SEEDS) * len(MOTIONS)

# Of 21 pairs each: how many must be named right, and how many may be blamed for something else.
# Some faults cannot always be told: the rate of a sine looks like a sine.
BOUNDS = {
    "none": (21, 0),
    "negated, noise in one half": (15, 0),
    "s1 is the rate": (17, 0),
    "s2 is the rate": (16, 1),
    "exchanged": (18, 0),
    "s1 stuck": (18, 0),
    "s1 stuck in the second half": (18, 0),
    "unrelated": (12, 2),
}
ALMOST_ALWAYS = (20, 0)


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
