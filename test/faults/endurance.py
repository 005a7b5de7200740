# SPDX-License-Identifier: Apache-2.0
"""Long runs with faults: what is held stays flat, what comes out stays right."""

from __future__ import annotations

import os
import random
import statistics
import time
from collections import Counter, deque
from collections.abc import Iterator
from typing import NamedTuple

from nodes.watching import Diagnostics

from faults.fusing import Watched
from faults.injector import FAULTS, Fault
from faults.meeting import meet
from faults.streams import S1, S2, Arrival, Stream, clean_stream
from faults.usage import Watch
from faults.waiting import as_arguments
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.testing import Harness

BLOCK = 200
"""Samples of S1 with one fault in them."""

LOOKS = 40

KEEPS_ITS_TIMELINE = {name: FAULTS[name] for name in FAULTS if not name.startswith("stamps ")}
"""Faults after which time goes on, so that blocks can follow one another."""

PAIRED = {"trigger": "pair", "predictor.enabled": True}

AHEAD, LONGEST = 3, 8
"""Samples that may be under way, and a fault's length: with a burst on top there are fewer
estimates at once than the queue of estimates holds, so none is lost."""


def troubled(
    samples: int, rng: random.Random, drops: Counter[Drop], faults: dict[str, Fault]
) -> Iterator[Arrival]:
    """Yield a stream of any length, with a fault in every block; count what is to be dropped."""
    for first in range(0, samples, BLOCK):
        block: Stream = clean_stream(min(BLOCK, samples - first), 1, first)
        if len(block) < 2 * BLOCK:
            yield from block
            continue
        sensor = rng.choice((S1, S2))
        start, length = rng.randrange(10, 100), rng.randrange(1, LONGEST)
        spoilt = rng.choice(list(faults.values()))(block, sensor, start, length, rng)
        drops += spoilt.drops
        yield from spoilt.stream


class Stepped(NamedTuple):
    """What a long run in the core showed.

    Attributes:
        samples: Samples of S1.
        estimates: Estimates, all finite and within their bound.
        seconds: How long it took.
        growth: Memory after the first look, at most, MiB.
        late_growth: The same, in the second half, MiB.
        more_descriptors: Descriptors after the first look, at most.
    """

    samples: int
    estimates: int
    seconds: float
    growth: float
    late_growth: float
    more_descriptors: int


def step(samples: int, seed: int) -> Stepped:
    """Step the core through a long stream with faults.

    Raises:
        AssertionError: An estimate is not finite or out of its bound, or a count is wrong.
    """
    drops: Counter[Drop] = Counter()
    watched, watch = Watched(replace(Parameters(), PAIRED)), Watch(os.getpid())
    begin, estimates = time.monotonic(), 0
    every = max(1, 2 * samples // LOOKS)
    stream = troubled(samples, random.Random(seed), drops, KEEPS_ITS_TIMELINE)
    for k, each in enumerate(stream):
        estimates += len(watched.receive(each))
        if k % every == every // 2:
            watch.look()
    fusion = watched.fusion
    counted = fusion.s1.dropped + fusion.s2.dropped
    del counted[Drop.UNPAIRED]
    assert counted == drops
    assert fusion.restarts == 0
    return Stepped(
        samples,
        estimates,
        time.monotonic() - begin,
        watch.growth,
        watch.late_growth,
        watch.more_descriptors,
    )


class Ran(NamedTuple):
    """What a long run over DDS showed.

    Attributes:
        seconds: How long it took.
        rate: Samples of S1 per second.
        estimates: Estimates that came, each the same as the core's, bit for bit.
        growth: Memory of the node after the first look, at most, MiB.
        late_growth: The same, in the second half, MiB.
        more_descriptors: Its descriptors after the first look, at most.
        first_latency: Median from sending to receiving, first tenth, ms.
        last_latency: The same, last tenth, ms.
    """

    seconds: float
    rate: float
    estimates: int
    growth: float
    late_growth: float
    more_descriptors: int
    first_latency: float
    last_latency: float


def run_over_dds(seconds: float, rate: float, seed: int) -> Ran:
    """Run fusion_node, a process of its own, for long at a high rate with faults.

    Estimates are compared with the core's as they come; the node's counts with the faults.

    Args:
        seconds: How long.
        rate: Samples of S1 per second, as far as the machine can.
        seed: Of the faults.

    Raises:
        AssertionError: An estimate or a count is wrong.
        TimeoutError: An estimate does not come.
    """
    drops: Counter[Drop] = Counter()
    watched = Watched(replace(Parameters(), PAIRED))
    due: deque[tuple[int, float, float]] = deque()
    latencies: deque[tuple[float, float]] = deque(maxlen=4_000_000)
    with Harness() as harness:
        node = harness.start("fusion_node", *as_arguments({**PAIRED, "qos": "reliable"}))
        feed = harness.feed()
        meet(harness, feed)
        feed.estimates.clear()
        watch, diagnostics = Watch(node.pid), Diagnostics(harness)
        samples = round(seconds * rate)
        stream = troubled(samples, random.Random(seed), drops, KEEPS_ITS_TIMELINE)
        begin, sent, received = time.monotonic(), 0, 0
        next_look = begin

        def take() -> None:
            nonlocal received
            for estimate in feed.estimates:
                stamp_ns, value, at = due.popleft()
                assert estimate == Sample(stamp_ns, value)
                latencies.append((at - begin, time.monotonic() - at))
                received += 1
            feed.estimates.clear()

        def may_send() -> bool:
            take()
            return len(due) < AHEAD and time.monotonic() >= begin + sent / rate

        def all_received() -> bool:
            take()
            return not due

        for each in stream:
            if each.sensor == S1:
                sent += 1
                harness.spin_until(may_send, "estimates under way")
                if time.monotonic() >= next_look:
                    watch.look()
                    next_look += max(0.2, seconds / LOOKS)
                    del diagnostics._messages[:-5]
            for fused in watched.receive(each):
                due.append((fused.stamp_ns, fused.estimate.value, time.monotonic()))
            feed.publish(feed.s1 if each.sensor == S1 else feed.s2, each.sample)
        harness.spin_until(all_received, "the last estimate")
        watch.look()
        took = time.monotonic() - begin
        said = [diagnostics.next(f"fusion_node: {sensor}").values for sensor in (S1, S2)]
        for reason in set(Drop) - {Drop.UNPAIRED}:
            counted = sum(int(each[f"dropped: {reason.value}"]) for each in said)
            assert counted == drops[reason], (reason, counted, drops)
    tenth = len(latencies) // 10
    times = [1e3 * latency for _, latency in latencies]
    return Ran(
        took,
        sent / took,
        received,
        watch.growth,
        watch.late_growth,
        watch.more_descriptors,
        statistics.median(times[tenth : 2 * tenth]),
        statistics.median(times[-tenth:]),
    )
