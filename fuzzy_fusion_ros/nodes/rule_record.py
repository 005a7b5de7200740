# SPDX-License-Identifier: Apache-2.0
"""Which rules lead, and how far the membership functions and the gate are used."""

from __future__ import annotations

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.core.estimator import FUSED
from fuzzy_fusion_ros.core.numerics import clamped, seconds_between
from fuzzy_fusion_ros.online.verdict import Fused

LONGEST_STEP = 1.0
"""Longest time between two estimates credited to the rule that led at the first, seconds."""

SATURATED = 0.999
"""A grade of *large* from which on the input counts as fully large, rounding aside."""


class RuleRecord:
    """Which rules have led and how far the membership functions were used, since a start.

    Attributes:
        estimates: Fused estimates seen.
        seconds: How long each rule of Table 1 led, in its order.
        difference: Lowest and highest grade of *large* of the difference.
        rate: Lowest and highest grade of *large* of the rate.
        predictions: Predictions that came to the gate.
        accepted: Predictions that it let count.
    """

    def __init__(self) -> None:
        self.estimates = 0
        self.seconds = [0.0] * len(FiringStrengths._fields)
        self.difference = (1.0, 0.0)
        self.rate = (1.0, 0.0)
        self.predictions = 0
        self.accepted = 0
        self._led: int | None = None
        self._last_ns = 0
        self._apart_since_ns: int | None = None

    @property
    def watched_s(self) -> float:
        """Time that counted for any rule, seconds."""
        return sum(self.seconds)

    @property
    def apart_s(self) -> float:
        """For how long the difference has been fully large without a break, seconds."""
        since_ns = self._last_ns if self._apart_since_ns is None else self._apart_since_ns
        return seconds_between(since_ns, self._last_ns)

    def see(self, fused: Fused) -> None:
        """Take an estimate; those of a single sensor only end what went on."""
        estimate, stamp_ns = fused.estimate, fused.stamp_ns
        if estimate.mode != FUSED:
            self._led = self._apart_since_ns = None
            return
        strengths = estimate.aggregate.strengths
        if self._led is not None:
            step = seconds_between(self._last_ns, stamp_ns)
            self.seconds[self._led] += clamped(step, 0.0, LONGEST_STEP)
        self._led, self._last_ns = strengths.index(max(strengths)), stamp_ns
        _, fast, apart, both = strengths
        difference, rate = apart + both, fast + both
        if not self.difference[0] <= difference <= self.difference[1]:
            self.difference = _widened(self.difference, difference)
        if not self.rate[0] <= rate <= self.rate[1]:
            self.rate = _widened(self.rate, rate)
        if difference < SATURATED:
            self._apart_since_ns = None
        elif self._apart_since_ns is None:
            self._apart_since_ns = stamp_ns
        self.estimates += 1
        self.predictions += estimate.prediction.exists
        self.accepted += estimate.accepted


def _widened(span: tuple[float, float], value: float) -> tuple[float, float]:
    return min(span[0], value), max(span[1], value)
