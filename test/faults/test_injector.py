# SPDX-License-Identifier: Apache-2.0
"""Each fault in each sensor, straight into the core: finite, bounded, counted, and over soon."""

from __future__ import annotations

import itertools
import random
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest

from faults.fusing import recovery, run
from faults.injector import COSTS_ITS_SAMPLES_ONLY, FAULTS, Injected
from faults.promises import VARIANTS, promised, tolerance
from faults.streams import S1, S2, clean_stream
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SEEDS = range(2)


def injected(fault: str, sensor: str, every: int, samples: int, seed: int) -> Injected:
    """Return a stream with a fault at a random place."""
    rng = random.Random(f"{fault} {sensor} {seed}")
    step = 1 if sensor == S1 else every
    length = rng.randint(1, 30) // step + 1
    first = rng.randint(10, 100) // step + 1
    return FAULTS[fault](clean_stream(samples, every), sensor, first, length, rng)


QUICK_IF_PAIRED = {("stamps ahead", S1), ("spikes", S2)}
"""Faults that are tried with paired samples in a quick run as well, one for each sensor."""


def cases() -> Iterator[object]:
    """Yield variant, samples of S1 for each of S2, fault and sensor."""
    for fault, sensor in itertools.product(FAULTS, (S1, S2)):
        yield pytest.param("plain", 1, fault, sensor)
        yield pytest.param("predictor", 10, fault, sensor)
        slow = pytest.mark.slow("as with the predictor")
        yield pytest.param("plain", 10, fault, sensor, marks=slow)
        quick = (fault, sensor) in QUICK_IF_PAIRED
        slow = pytest.mark.slow("as with the other trigger")
        yield pytest.param("paired", 1, fault, sensor, marks=() if quick else slow)


@pytest.mark.parametrize(("variant", "every", "fault", "sensor"), list(cases()))
def test_a_fault_is_survived_counted_and_over_soon(
    variant: str, every: int, fault: str, sensor: str
) -> None:
    changes = VARIANTS[variant]
    parameters = replace(Parameters(), changes)
    within = promised(fault, sensor)
    samples = 250 + within
    clean = run(parameters, clean_stream(samples, every))
    for seed in SEEDS:
        spoilt = injected(fault, sensor, every, samples, seed)
        ran = run(parameters, spoilt.stream)
        others = {name: drops for name, drops in ran.dropped.items() if name != sensor}
        assert unpaired_aside(ran.dropped[sensor]) == spoilt.drops
        assert all(unpaired_aside(drops) == Counter() for drops in others.values())
        assert ran.restarts == spoilt.restarts
        assert recovery(clean, spoilt, ran, tolerance(changes)) <= within


def unpaired_aside(drops: Counter[Drop]) -> Counter[Drop]:
    """Return what was dropped for what it is, not for want of a partner."""
    return Counter({reason: n for reason, n in drops.items() if reason is not Drop.UNPAIRED})


@pytest.mark.parametrize("sensor", [S1, S2])
@pytest.mark.parametrize("fault", COSTS_ITS_SAMPLES_ONLY)
@pytest.mark.parametrize("changes", VARIANTS.values(), ids=VARIANTS)
def test_dropped_samples_leave_no_trace_at_all(
    changes: dict[str, Any], fault: str, sensor: str
) -> None:
    parameters = replace(Parameters(), changes)
    clean = clean_stream(200)
    spoilt = injected(fault, sensor, 1, 200, 1)
    good = set(clean)
    rest, seen = [], set()
    for each in spoilt.stream:
        if each in good and each not in seen:
            rest.append(each)
            seen.add(each)
    assert run(parameters, spoilt.stream).estimates == run(parameters, rest).estimates


@pytest.mark.parametrize("fault", FAULTS)
def test_equal_seeds_give_equal_faults(fault: str) -> None:
    one, two, other = (injected(fault, S1, 1, 300, seed) for seed in (3, 3, 4))
    assert repr(one) == repr(two)
    assert repr(one) != repr(other)
    assert len(clean_stream(300)) == 600
