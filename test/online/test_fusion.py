# SPDX-License-Identifier: Apache-2.0
"""Guards, trigger and estimator in one: what a node and a replay feed."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference import signals
from searching import examples

from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY, S2_ONLY
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.online.timeline import EVIDENCE
from fuzzy_fusion_ros.online.verdict import Fused, Verdict
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace

SECOND = 1_000_000_000
STEP = 10_000_000

PLAIN = replace(Parameters(), {"s1.timeout": 1.0, "s2.timeout": 5.0, "future_tolerance": 10.0})
PREDICTING = replace(PLAIN, {"predictor.enabled": True})

Event = tuple[str, int, float]  # s1 or s2, stamp, value


def events_of(recording: signals.Recording) -> list[Event]:
    """Return a recording's samples in the order of stamps, S2 first."""
    s2 = [("s2", stamp_ns, value) for stamp_ns, value in recording.s2]
    s1 = [("s1", stamp_ns, value) for stamp_ns, value in recording.s1]
    return sorted(s2 + s1, key=lambda event: event[1])


def feed(fusion: Fusion, event: Event, now_ns: int | None = None) -> Verdict:
    """Feed one sample, received at its stamp unless said otherwise."""
    sensor, stamp_ns, value = event
    receive = fusion.on_s1 if sensor == "s1" else fusion.on_s2
    return receive(Sample(stamp_ns, value), now_ns)


def feed_all(fusion: Fusion, events: list[Event]) -> list[Fused]:
    """Feed samples and return the estimates."""
    return [fused for event in events for fused in feed(fusion, event).estimates]


def modes(estimates: list[Fused]) -> list[int]:
    """Return the modes of estimates, repetitions left out."""
    found = [fused.estimate.mode for fused in estimates]
    return [mode for k, mode in enumerate(found) if k == 0 or mode != found[k - 1]]


def test_an_estimate_has_the_stamp_of_its_sample_of_s1() -> None:
    fusion = Fusion(PLAIN)
    assert feed(fusion, ("s2", SECOND, 0.5)).estimates == ()
    (fused,) = feed(fusion, ("s1", SECOND + 3, 0.5)).estimates
    assert (fused.stamp_ns, fused.estimate.mode, fused.estimate.value) == (SECOND + 3, FUSED, 0.5)


def test_while_s2_is_awaited_there_is_no_estimate() -> None:
    fusion = Fusion(PLAIN)
    assert feed_all(fusion, [("s1", SECOND + k * STEP, 0.1) for k in range(100)]) == []


@pytest.mark.parametrize(
    ("event", "now_ns", "reason"),
    [
        (("s1", 5 * SECOND, math.nan), 5 * SECOND, Drop.NOT_FINITE),
        (("s2", 5 * SECOND, math.inf), 5 * SECOND, Drop.NOT_FINITE),
        (("s2", 5 * SECOND, -math.inf), 5 * SECOND, Drop.NOT_FINITE),
        (("s1", 0, 0.1), 5 * SECOND, Drop.ZERO_STAMP),
        (("s2", 5 * SECOND, 0.1), -6 * SECOND, Drop.FUTURE_STAMP),
        (("s1", -SECOND, 0.1), 5 * SECOND, Drop.NEGATIVE_STAMP),
        (("s1", 2 * SECOND, 0.1), 2 * SECOND, Drop.NOT_NEWER),
        (("s1", 2 * SECOND - 1, 0.1), 2 * SECOND, Drop.NOT_NEWER),
        (("s2", 1, 0.1), 2 * SECOND, Drop.NOT_NEWER),
    ],
)
def test_what_is_dropped_is_counted_and_changes_nothing(
    event: Event, now_ns: int, reason: Drop
) -> None:
    dropping, clean = Fusion(PLAIN), Fusion(PLAIN)
    before = [("s2", 2 * SECOND, 0.5), ("s1", 2 * SECOND, 0.6)]
    after = [("s2", 6 * SECOND, 0.7), ("s1", 6 * SECOND, 0.6)]
    assert feed_all(dropping, before) == feed_all(clean, before)
    verdict = feed(dropping, event, now_ns)
    assert (verdict.admitted, verdict.estimates) == (0, ())
    assert feed_all(dropping, after) == feed_all(clean, after)
    guard = dropping.s1 if event[0] == "s1" else dropping.s2
    assert (guard.dropped, guard.last_drop) == ({reason: 1}, reason)
    assert dropping.restarts == 0


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_the_first_message_may_be_the_bad_one(value: float) -> None:
    fusion = Fusion(PLAIN)
    events = [("s1", SECOND, value), ("s2", SECOND, value), ("s2", SECOND, 0.5)]
    (fused,) = feed_all(fusion, [*events, ("s1", SECOND, 0.5)])
    assert fused.estimate.value == 0.5


def test_samples_are_counted() -> None:
    fusion = Fusion(PLAIN)
    feed_all(fusion, events_of(signals.irregular(90)))
    assert (fusion.s1.admitted, fusion.s2.admitted) == (90, 30)
    assert not fusion.s1.dropped
    assert not fusion.s2.dropped


def test_each_sensor_may_be_lost_and_comes_back_by_itself() -> None:
    def both(start: int, end: int) -> list[Event]:
        ticks = range(start * 100, end * 100)
        return [(s, SECOND + k * STEP, 0.5) for k in ticks for s in ("s2", "s1")]

    def only(sensor: str, start: int, end: int) -> list[Event]:
        return [event for event in both(start, end) if event[0] == sensor]

    fusion = Fusion(PLAIN)
    day = [both(0, 1), only("s1", 1, 9), both(9, 10), only("s2", 10, 14), both(14, 15)]
    estimates = [feed_all(fusion, events) for events in day]
    assert [modes(each) for each in estimates] == [
        [FUSED],
        [FUSED, S1_ONLY],
        [FUSED],
        [S2_ONLY],
        [S2_ONLY, FUSED],
    ]
    assert len(estimates[3]) == 400 - 100  # S1 is missed for a second first
    assert {fused.estimate.value for each in estimates for fused in each} == {0.5}


@pytest.mark.parametrize("trigger", ["s1", "pair", "timer"])
def test_s2_alone_speaks_when_s1_never_comes(trigger: str) -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": trigger}))
    said = feed_all(fusion, [("s2", SECOND + k * STEP, 0.01 * k) for k in range(201)])
    assert [fused.estimate.mode for fused in said] == [S2_ONLY] * 100
    assert said[0].stamp_ns == 2 * SECOND + STEP
    assert said[-1].estimate.value == 2.0


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_s1_alone_speaks_when_s2_never_comes(trigger: str) -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": trigger, "s2.timeout": 1.0}))
    said = feed_all(fusion, [("s1", SECOND + k * STEP, 0.01 * k) for k in range(201)])
    assert [fused.estimate.mode for fused in said] == [S1_ONLY] * 100
    assert said[0].stamp_ns == 2 * SECOND + STEP
    assert said[-1].estimate.value == 2.0


def test_the_timer_estimates_at_ticks() -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": "timer"}))
    assert fusion.on_tick().estimates == ()
    feed_all(fusion, [("s2", SECOND, 0.5), ("s1", SECOND, 0.5), ("s1", SECOND + STEP, 0.5)])
    (fused,) = fusion.on_tick().estimates
    assert (fused.stamp_ns, fused.estimate.mode) == (SECOND + STEP, FUSED)
    assert fusion.on_tick().estimates == ()


@pytest.mark.parametrize("trigger", ["s1", "pair"])
def test_a_tick_means_nothing_to_the_other_triggers(trigger: str) -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": trigger}))
    feed(fusion, ("s1", SECOND, 0.5))
    assert fusion.on_tick().estimates == ()


def test_pairs_count_what_finds_no_partner_for_each_sensor() -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": "pair"}))
    events: list[Event] = [("s1", SECOND + k, 0.1) for k in (1, 2, 3, 5)]
    events += [("s2", SECOND + k, 0.1) for k in (4, 5)]
    assert [fused.stamp_ns for fused in feed_all(fusion, events)] == [SECOND + 5]
    assert fusion.s1.dropped == {Drop.UNPAIRED: 3}
    assert fusion.s2.dropped == {Drop.UNPAIRED: 1}


@examples(50)
@given(st.lists(st.booleans(), min_size=200, max_size=200), st.booleans())
def test_pairs_give_the_same_estimates_in_any_order_of_arrival(
    s1_first: list[bool], predicting: bool
) -> None:
    parameters = replace(PREDICTING if predicting else PLAIN, {"trigger": "pair"})
    recording = signals.regular(100)
    s1 = [("s1", *sample) for sample in recording.s1]
    s2 = [("s2", *sample) for sample in recording.s2]
    in_step = [event for both in zip(s2, s1, strict=True) for event in both]
    shuffled: list[Event] = []
    for first in s1_first:
        queue = s1 if s1 and (first or not s2) else s2
        shuffled.append(queue.pop(0))
    assert feed_all(Fusion(parameters), shuffled) == feed_all(Fusion(parameters), in_step)


@pytest.mark.parametrize("late", ["s1", "s2"])
def test_pairs_survive_a_sensor_that_comes_back_with_what_it_missed(late: str) -> None:
    """The late sensor's samples are older than what the other has been let through with."""
    timeouts = {"s1.timeout": 0.5, "s2.timeout": 0.5, "aggregator.rate_time_constant": 0.03}
    fusion = Fusion(replace(PREDICTING, {"trigger": "pair", **timeouts}))
    on_time = "s1" if late == "s2" else "s2"
    stamps = [SECOND + k * STEP for k in range(200)]
    events: list[Event] = [(late, SECOND, 0.1)]
    events += [(on_time, stamp, 0.1) for stamp in stamps[:80]]
    events += [(late, stamp, 0.1) for stamp in stamps[1:80]]
    events += [(sensor, stamp, 0.1) for stamp in stamps[80:] for sensor in ("s1", "s2")]
    said = feed_all(fusion, events)
    assert modes(said) == [FUSED, S1_ONLY if late == "s2" else S2_ONLY, FUSED]
    assert [fused.stamp_ns for fused in said] == sorted({fused.stamp_ns for fused in said})
    assert said[-1].stamp_ns == stamps[-1]
    assert fusion.restarts == 0


@examples(200)
@given(
    st.lists(
        st.tuples(
            st.sampled_from(["s1", "s2", "tick"]),
            st.integers(0, 4 * SECOND // STEP).map(lambda k: k * STEP),
            st.floats(allow_nan=True, allow_infinity=True),
        ),
        max_size=60,
    ),
    st.sampled_from(["s1", "pair", "timer"]),
)
def test_whatever_comes_in_what_comes_out_is_finite_and_rises_but_for_restarts(
    events: list[Event], trigger: str
) -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": trigger, "s1.timeout": 0.1, "s2.timeout": 0.2}))
    newest_ns = 0
    for event in events:
        verdict = fusion.on_tick() if event[0] == "tick" else feed(fusion, event)
        if verdict.restarted:
            newest_ns = 0
        for fused in verdict.estimates:
            assert fused.stamp_ns > newest_ns
            assert math.isfinite(fused.estimate.value)
            newest_ns = fused.stamp_ns


@pytest.mark.parametrize("trigger", ["s1", "pair"])
@pytest.mark.parametrize("predicting", [False, True])
@pytest.mark.parametrize("samples", [6, 40, 300])
@pytest.mark.parametrize("s2_first", [True, False])
def test_looping_gives_the_same_estimates_again_and_again(
    trigger: str, predicting: bool, samples: int, s2_first: bool
) -> None:
    """Invariant 2, for recordings shorter than both timeouts, than S2's, and longer than both."""
    timeouts = {"s1.timeout": 0.2, "s2.timeout": 0.8}
    parameters = replace(PREDICTING if predicting else PLAIN, {"trigger": trigger, **timeouts})
    events = events_of(signals.regular(samples))
    if not s2_first:
        events = sorted(events, key=lambda event: event[1:2] + event[:1])
    once = feed_all(Fusion(parameters), events)
    fusion = Fusion(parameters)
    assert len(once) >= samples - 1
    loops = 4
    assert feed_all(fusion, loops * events) == loops * once
    assert fusion.restarts == loops - 1
    assert not fusion.s1.dropped
    assert not fusion.s2.dropped


@pytest.mark.parametrize("sensor", ["s1", "s2"])
def test_a_jump_back_of_either_sensor_restarts_both(sensor: str) -> None:
    fusion = Fusion(PLAIN)
    feed_all(fusion, [("s2", 9 * SECOND, 0.5), ("s1", 9 * SECOND, 0.5)])
    other = "s2" if sensor == "s1" else "s1"
    assert not feed(fusion, (sensor, SECOND, 0.1)).restarted  # alone, it waits for the other
    verdict = feed(fusion, (other, SECOND + STEP, 0.1))
    assert (verdict.restarted, verdict.admitted) == (True, 2)
    (fused,) = feed(fusion, ("s1", SECOND + 2 * STEP, 0.1)).estimates
    assert (fused.estimate.mode, fused.estimate.value) == (FUSED, 0.1)
    assert fusion.restarts == 1


@pytest.mark.parametrize("sensor", ["s1", "s2"])
@pytest.mark.parametrize("back_ns", [2 * SECOND, 3600 * SECOND])
def test_one_old_stamp_leaves_the_estimates_as_they_are(sensor: str, back_ns: int) -> None:
    events = events_of(signals.regular(300, 400_000 * STEP))
    place = next(k for k, each in enumerate(events) if k > 150 and each[0] == sensor)
    odd = events.copy()
    odd[place] = (sensor, events[place][1] - back_ns, events[place][2])
    without = events[:place] + events[place + 1 :]
    fusion = Fusion(PLAIN)
    assert feed_all(fusion, odd) == feed_all(Fusion(PLAIN), without)
    assert fusion.restarts == 0


def test_after_a_restart_s1_alone_waits_for_s2_to_speak() -> None:
    """S1 is 0.3 off; S2 speaks once a second."""
    fusion = Fusion(replace(PLAIN, {"s2.timeout": 3.0}))
    said = []
    for start in (100 * SECOND, 10 * SECOND):
        for k in range(300):
            stamp_ns = start + k * STEP
            if k % 100 == 50:
                said += feed(fusion, ("s2", stamp_ns, 1.0)).estimates
            said += feed(fusion, ("s1", stamp_ns, 1.3)).estimates
    assert fusion.restarts == 1
    assert {fused.estimate.mode for fused in said} == {FUSED}
    assert max(fused.estimate.value for fused in said) < 1.29


def test_a_false_start_costs_no_sample() -> None:
    fusion = Fusion(PLAIN)
    feed_all(fusion, [(s, 9000 * SECOND, 0.5) for s in ("s2", "s1")])
    feed_all(fusion, [("s1", SECOND + k, 0.5) for k in range(EVIDENCE)])
    feed_all(fusion, [(s, 9001 * SECOND + k, 0.5) for k in range(EVIDENCE) for s in ("s2", "s1")])
    assert fusion.restarts == 2
    assert fusion.s1.admitted == 1 + 2 * EVIDENCE
    assert not fusion.s1.dropped


def test_the_estimate_carries_the_message_of_the_s2_in_it() -> None:
    fusion = Fusion(replace(PLAIN, {"trigger": "pair"}))
    for k in (1, 2):
        fusion.on_s2(Sample(SECOND + k, 0.5, b"%d" % k))
    for k in (1, 2):
        (fused,) = fusion.on_s1(Sample(SECOND + k, 0.5)).estimates
        assert fused.s2_message == b"%d" % k


def test_reset_forgets_all_samples_and_keeps_the_counts() -> None:
    events = events_of(signals.irregular(200))
    fusion = Fusion(PREDICTING)
    once = feed_all(fusion, events)
    feed(fusion, ("s1", 0, 0.0))
    fusion.reset()
    assert feed_all(fusion, events) == once
    assert fusion.s1.admitted == 400
    assert fusion.s1.dropped == {Drop.ZERO_STAMP: 1}
    assert fusion.restarts == 0


def test_two_fusions_share_nothing() -> None:
    events = events_of(signals.irregular(150))
    once = feed_all(Fusion(PREDICTING), events)
    one, other = Fusion(PREDICTING), Fusion(PREDICTING)
    pairs = [(feed(one, event).estimates, feed(other, event).estimates) for event in events]
    assert [fused for ours, _ in pairs for fused in ours] == once
    assert [fused for _, others in pairs for fused in others] == once
