# SPDX-License-Identifier: Apache-2.0
"""A stream through the core's fusion, each estimate watched as it comes."""

from __future__ import annotations

import math
from collections import Counter
from typing import NamedTuple

from faults.injector import Injected
from faults.streams import S1, S2, Arrival, Stream
from fuzzy_fusion_ros.core.estimator import FUSED
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.online.trigger import PENDING, Step
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten


class Ran(NamedTuple):
    """What came of a stream.

    Attributes:
        estimates: All estimates in order.
        dropped: What the guards counted, by sensor.
        restarts: How often time was seen to jump back.
        bounded: How many estimates were compared with both sensors.
    """

    estimates: list[Fused]
    dropped: dict[str, Counter[Drop]]
    restarts: int
    bounded: int


CONDITIONING = (
    "s1.spike_threshold",
    "s1.lowpass_time_constant",
    "s1.bias_time_constant",
    "signal.period",
    "self_tuning",
)
"""With one of these, an estimate is not bounded by samples as they come."""


class Watched:
    """A fusion whose every estimate must be finite and within its bound.

    Attributes:
        fusion: The fusion.
        bounded: How many estimates have been compared with both sensors.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.fusion = Fusion(parameters)
        self.bounded = 0
        values = flatten(parameters)
        self._conditioned = any(values[name] for name in CONDITIONING)
        self._recent: dict[str, dict[int, float]] = {"s1": {}, "s2": {}}

    def receive(self, arrival: Arrival) -> tuple[Fused, ...]:
        """Feed a sample and return the estimates that it leads to.

        Raises:
            AssertionError: The estimate is not finite or beyond its bound.
        """
        receive = self.fusion.on_s1 if arrival.sensor == S1 else self.fusion.on_s2
        verdict = receive(arrival.sample, arrival.now_ns)
        due = list(verdict.estimates)
        for step in verdict.steps:
            self._remember(step)
            at = step.s2 if step.s2_alone else step.s1
            if due and at is not None and due[0].stamp_ns == at.stamp_ns:
                self._check(due.pop(0))
        assert due == []
        return verdict.estimates

    def _check(self, fused: Fused) -> None:
        estimate = fused.estimate
        fa, prediction = estimate.aggregate, estimate.prediction
        assert all(map(math.isfinite, (estimate.value, fa.value, fa.weight, fa.drift)))
        assert math.isfinite(prediction.value)
        if not self._conditioned:
            self._check_bound(fused)
        if not estimate.accepted:
            assert estimate.value == fa.value
        tolerance = self.fusion.parameters.gate.tolerance
        assert abs(estimate.value - fa.value) <= 0.5 * tolerance + 1e-12 * abs(fa.value)

    def _check_bound(self, fused: Fused) -> None:
        estimate, fa = fused.estimate, fused.estimate.aggregate
        s1, s2 = self._value("s1", fused.stamp_ns), self._value("s2", fused.stamp_ns)
        if estimate.mode == FUSED:
            assert s1 is not None
            assert s2 is not None
            assert min(s1, s2) - fa.drift <= fa.value <= max(s1, s2) + fa.drift
            drift = self.fusion.parameters.aggregator.drift
            assert fa.drift <= max(drift.small, drift.large) * (1.0 + 1e-12)
            self.bounded += 1
        else:
            assert fa.value in (s1, s2)

    def _remember(self, step: Step) -> None:
        for recent, sample in ((self._recent["s2"], step.s2), (self._recent["s1"], step.s1)):
            if sample is not None:
                recent.pop(sample.stamp_ns, None)  # to the end
                recent[sample.stamp_ns] = sample.value
                if len(recent) > 2 * PENDING:
                    del recent[next(iter(recent))]

    def _value(self, sensor: str, stamp_ns: int) -> float | None:
        """Return what a sensor had to say at a stamp; of S2 what it said last, unless paired."""
        recent = self._recent[sensor]
        paired = self.fusion.parameters.trigger == "pair" and stamp_ns in recent
        if sensor == S2 and not paired and recent:
            return recent[next(reversed(recent))]
        return recent.get(stamp_ns)


def run(parameters: Parameters, stream: Stream) -> Ran:
    """Run a whole stream through a fusion of its own.

    Raises:
        AssertionError: An estimate is not finite or beyond its bound.
    """
    watched = Watched(parameters)
    estimates = [fused for each in stream for fused in watched.receive(each)]
    fusion = watched.fusion
    dropped = {"s1": fusion.s1.dropped, "s2": fusion.s2.dropped}
    return Ran(estimates, dropped, fusion.restarts, watched.bounded)


def recovery(clean: Ran, injected: Injected, ran: Ran, within: float) -> int:
    """Return how many samples of S1 it takes after a fault until all estimates are as without it.

    Args:
        clean: What came of the stream without the fault.
        injected: The stream with it.
        ran: What came of that.
        within: How far the estimates may differ, unit of the signal.
    """
    expected = {
        fused.stamp_ns + injected.shift_ns: fused.estimate.value for fused in clean.estimates
    }
    estimates = {fused.stamp_ns: fused for fused in ran.estimates}
    samples = back = 0
    for k in range(injected.end, len(injected.stream)):
        sensor, sample, _ = injected.stream[k]
        if sensor == S1:
            samples += 1
            fused = estimates.get(sample.stamp_ns)
            wanted = expected.get(sample.stamp_ns, math.nan)
            if fused is None or not abs(fused.estimate.value - wanted) <= within:
                back = samples
    return back
