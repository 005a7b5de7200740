# SPDX-License-Identifier: Apache-2.0
"""Triggers: which samples make a step, and when."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.trigger import (
    NOTHING,
    PENDING,
    PairTrigger,
    S1Trigger,
    Step,
    TimerTrigger,
    trigger_for,
)
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000


def at(stamp_ns: int) -> Sample:
    """Return a sample that can be told by its stamp."""
    return Sample(stamp_ns, stamp_ns / 7.0)


def pair_trigger(s1_timeout: float = 1.0, s2_timeout: float = 5.0) -> PairTrigger:
    """Return a pair trigger with these timeouts."""
    changes = {"trigger": "pair", "s1.timeout": s1_timeout, "s2.timeout": s2_timeout}
    return PairTrigger(replace(Parameters(), changes))


@pytest.mark.parametrize(
    ("name", "kind"), [("s1", S1Trigger), ("pair", PairTrigger), ("timer", TimerTrigger)]
)
def test_each_trigger_goes_by_its_name(name: str, kind: type) -> None:
    assert type(trigger_for(replace(Parameters(), {"trigger": name}))) is kind


def test_s1_estimates_at_every_s1() -> None:
    trigger = S1Trigger(Parameters())
    assert trigger.on_s2(at(1)) == Step(s2=at(1))
    assert trigger.on_s1(at(2)) == Step(s1=at(2))
    assert trigger.on_s1(at(3)) == Step(s1=at(3))
    assert trigger.on_tick() == NOTHING == Step(None, None, 0, 0)


def test_timer_estimates_at_the_newest_s1_once() -> None:
    trigger = TimerTrigger(Parameters())
    assert trigger.on_tick() == NOTHING
    assert trigger.on_s1(at(1)) == NOTHING
    assert trigger.on_s1(at(2)) == NOTHING
    assert trigger.on_s2(at(3)) == Step(s2=at(3))
    assert trigger.on_tick() == Step(s1=at(2))
    assert trigger.on_tick() == NOTHING


def test_pair_waits_for_the_partner_whichever_comes_first() -> None:
    trigger = pair_trigger()
    assert trigger.on_s1(at(1)) == NOTHING
    assert trigger.on_s2(at(1)) == Step(s2=at(1), s1=at(1))
    assert trigger.on_s2(at(2)) == NOTHING
    assert trigger.on_s1(at(2)) == Step(s2=at(2), s1=at(2))
    assert trigger.on_tick() == NOTHING


def test_pair_gives_up_on_what_is_older_than_a_pair() -> None:
    trigger = pair_trigger()
    for stamp_ns in (1, 2, 4):
        assert trigger.on_s1(at(stamp_ns)) == NOTHING
    assert trigger.on_s2(at(3)) == NOTHING
    assert trigger.on_s2(at(4)) == Step(at(4), at(4), unpaired_s1=2, unpaired_s2=1)


def test_pair_keeps_what_is_newer_than_a_pair() -> None:
    trigger = pair_trigger()
    for stamp_ns in (1, 2, 3):
        trigger.on_s1(at(stamp_ns))
    assert [trigger.on_s2(at(n)) for n in (1, 2, 3)] == [Step(at(n), at(n)) for n in (1, 2, 3)]


@pytest.mark.parametrize(("late_ns", "lost"), [(5 * SECOND, False), (5 * SECOND + 1, True)])
def test_pair_lets_s1_through_alone_once_s2_is_lost(late_ns: int, lost: bool) -> None:
    trigger = pair_trigger()
    trigger.on_s1(at(1))
    trigger.on_s2(at(1))
    assert trigger.on_s1(at(1 + late_ns)) == (Step(s1=at(1 + late_ns)) if lost else NOTHING)


@pytest.mark.parametrize(("late_ns", "lost"), [(SECOND, False), (SECOND + 1, True)])
def test_pair_lets_s2_through_alone_once_s1_is_lost(late_ns: int, lost: bool) -> None:
    trigger = pair_trigger()
    trigger.on_s2(at(1))
    trigger.on_s1(at(1))
    assert trigger.on_s2(at(1 + late_ns)) == (Step(s2=at(1 + late_ns)) if lost else NOTHING)


def test_pair_awaits_a_sensor_from_the_first_sample_of_the_other() -> None:
    trigger = pair_trigger(s1_timeout=1.0)
    assert trigger.on_s2(at(SECOND)) == NOTHING
    assert trigger.on_s2(at(2 * SECOND)) == NOTHING
    assert trigger.on_s2(at(2 * SECOND + 1)) == Step(s2=at(2 * SECOND + 1), unpaired_s2=2)


def test_pair_never_goes_back_behind_what_it_let_through() -> None:
    """S2 comes back with old stamps, after S1 was let through alone."""
    trigger = pair_trigger(s2_timeout=1.0)
    trigger.on_s1(at(1))
    trigger.on_s2(at(1))
    assert trigger.on_s1(at(2)) == NOTHING
    assert trigger.on_s1(at(2 * SECOND)) == Step(s1=at(2 * SECOND), unpaired_s1=1)
    assert trigger.on_s2(at(2)) == Step(unpaired_s2=1)
    assert trigger.on_s2(at(2 * SECOND)) == Step(unpaired_s2=1)
    assert trigger.on_s1(at(3 * SECOND)) == NOTHING
    assert trigger.on_s2(at(3 * SECOND)) == Step(s2=at(3 * SECOND), s1=at(3 * SECOND))


def test_pair_sees_a_changed_timeout_at_once() -> None:
    trigger = pair_trigger(s2_timeout=5.0)
    trigger.on_s1(at(1))
    trigger.on_s2(at(1))
    trigger.parameters = replace(trigger.parameters, {"s2.timeout": 0.5})
    assert trigger.on_s1(at(SECOND)) == Step(s1=at(SECOND))


def test_pair_keeps_a_bounded_number_waiting() -> None:
    trigger = pair_trigger(s1_timeout=1e9, s2_timeout=1e9)
    sent = 3 * PENDING
    given_up = [trigger.on_s1(at(k + 1)).unpaired_s1 for k in range(sent)]
    assert given_up == [0] * PENDING + [1] * (sent - PENDING)
    assert trigger.on_s2(at(sent - PENDING)) == NOTHING  # its partner has gone first
    oldest = sent - PENDING + 1
    assert trigger.on_s2(at(oldest)) == Step(at(oldest), at(oldest), unpaired_s2=1)


def test_pair_keeps_a_bounded_number_of_s2_waiting() -> None:
    trigger = pair_trigger(s1_timeout=1e9)
    given_up = [trigger.on_s2(at(k + 1)).unpaired_s2 for k in range(2 * PENDING)]
    assert sum(given_up) == PENDING


@given(
    st.sets(st.integers(1, 40)).map(sorted),
    st.sets(st.integers(1, 40)).map(sorted),
    st.lists(st.booleans(), min_size=80, max_size=80),
)
def test_pair_gives_the_same_pairs_in_any_order_of_arrival(
    s1: list[int], s2: list[int], s1_first: list[bool]
) -> None:
    """Each sensor's own samples come in order; every sample is used or given up on once."""
    trigger = pair_trigger()
    steps = []
    left, right = list(s1), list(s2)
    for first in s1_first:
        if left and (first or not right):
            steps.append(trigger.on_s1(at(left.pop(0))))
        elif right:
            steps.append(trigger.on_s2(at(right.pop(0))))
    pairs = [(step.s2, step.s1) for step in steps if step.s1 is not None]
    assert pairs == [(at(n), at(n)) for n in s1 if n in s2]
    newest_pair = max((n for n in s1 if n in s2), default=0)
    assert sum(s.unpaired_s1 for s in steps) == len(
        [n for n in s1 if n < newest_pair and n not in s2]
    )
    assert sum(s.unpaired_s2 for s in steps) == len(
        [n for n in s2 if n < newest_pair and n not in s1]
    )
