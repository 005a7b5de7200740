# SPDX-License-Identifier: Apache-2.0
"""Continuous lines before the fusion: angles are unwrapped, rates are integrated.

Everything after it works on numbers of any size and need not know about either. It depends on the
samples alone, in the order in which they are admitted.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Protocol

from fuzzy_fusion_ros.core.conditioning import LONGEST_SPIKE
from fuzzy_fusion_ros.core.delay_line import delayed, empty_line, extended
from fuzzy_fusion_ros.core.numerics import bounded, seconds_between
from fuzzy_fusion_ros.core.observer import LASTING
from fuzzy_fusion_ros.core.periodic import nearest
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

EARLY = 1000
"""Samples of a rate that are kept until S2 speaks, the newest: enough for the delay of S2."""

FOLLOWED = 0.3
"""Share of the distance of a sample of S2 from where S1 has moved by which the next is placed: a
course that is random at standstill would else walk off by turns."""

DOUBTFUL = 0.25
"""A sample of S2 further than this share of a turn from where S1 has moved since is doubtful."""


class Lines(Protocol):
    """Puts samples of both sensors on continuous lines.

    Attributes:
        parameters: The parameters, replaced when they change.
    """

    parameters: Parameters

    def on_s1(self, sample: Sample) -> Sample | None:
        """Return an admitted sample of S1 on its line; None while there is no line."""

    def on_s2(self, sample: Sample) -> Sample:
        """Return an admitted sample of S2 on its line."""

    def early(self) -> Sequence[Sample]:
        """Return the samples of S1 that had no line before the first sample of S2, on it, once."""


class AsTheyAre:
    """Samples of values that do not wrap."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def on_s1(self, sample: Sample) -> Sample | None:
        """Return it."""
        return sample

    def on_s2(self, sample: Sample) -> Sample:
        """Return it."""
        return sample

    def early(self) -> Sequence[Sample]:
        """Return nothing."""
        return ()


class _S1Line:
    """S1 so far, and how S2 stood then.

    Attributes:
        value: The newest sample on its line; None before the first.
        s2: S2 on its line at that time; None before its first.
        stamp_ns: Stamp of the newest sample, 0 before the first.
    """

    def __init__(self) -> None:
        self.value: float | None = None
        self.s2: float | None = None
        self.stamp_ns = 0
        self._interval = 0.0
        self._rate = 0.0

    def step(self, stamp_ns: int, timeout: float) -> float:
        """Return the seconds since the last sample; infinite after a silence beyond the timeout."""
        dt = seconds_between(self.stamp_ns, stamp_ns)
        is_gap = dt > timeout_for(timeout, S1_TIMEOUT, self._interval)
        if self.stamp_ns:
            self._interval = followed(self._interval, dt)
        self.stamp_ns = stamp_ns
        return math.inf if is_gap else dt

    def mean_rate(self, rate: float) -> float:
        """Return the mean of the last rate and a new one."""
        mean, self._rate = 0.5 * self._rate + 0.5 * rate, rate
        return mean

    def moved(self, s2: float | None) -> float:
        """Return how far S2 has moved since the last sample of S1."""
        return 0.0 if s2 is None or self.s2 is None else s2 - self.s2


class Unwrapped:
    """Angles: each sample is the one nearest to where its line should be.

    S1 should be where it was: it is fast. S2 should have moved as S1 has, and so should S1 as S2
    after a silence. A spike of S1 says nothing of the turn of the samples after it: two in a row
    would add one, and all that follow would be spikes, a turn away. Nor does a sample of S2 that is
    not where S1's motion has brought it, unless several agree.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._s1 = _S1Line()
        self._s2: float | None = None
        self._credible: float | None = None  # about where S2 was, by which the next is placed
        self._s1_at_s2: float | None = None  # and S1 at it
        self._spikes = 0
        self._moved = False
        self._off, self._doubts = 0.0, 0
        self._past = empty_line()

    def on_s1(self, sample: Sample) -> Sample | None:
        """Unwrap it."""
        self._moved = True
        is_gap = math.isinf(self._s1.step(sample.stamp_ns, self.parameters.s1.timeout))
        expected = self._s1.value
        if expected is None:
            expected = 0.0 if self._s2 is None else self._s2
        elif is_gap:
            expected = self._followed(expected)
        elif self._is_spike(value := self._near(sample.value, expected), expected):
            return sample._replace(value=bounded(value))
        return self._on_line(sample, self._near(sample.value, expected))

    def on_s2(self, sample: Sample) -> Sample:
        """Unwrap it."""
        s1, expected = self._s1_shown(sample.stamp_ns), self._credible
        if expected is None:
            expected = 0.0 if s1 is None else s1
        elif s1 is not None and self._s1_at_s2 is not None:
            expected += s1 - self._s1_at_s2
        self._s2 = self._near(sample.value, expected)
        off, is_first, has_moved = self._s2 - expected, self._credible is None, self._moved
        if is_first or not self._is_doubtful(off):
            is_usual = has_moved and not is_first and self._doubts == 0
            share = FOLLOWED if is_usual else 1.0
            self._credible, self._s1_at_s2 = expected + share * off, s1
        return sample._replace(value=self._s2)

    def early(self) -> Sequence[Sample]:
        """Return nothing."""
        return ()

    def _followed(self, s1: float) -> float:
        """Return where S1 is after a silence if it has moved as S2 has."""
        if self._s1.s2 == self._s2:
            return s1
        moved = s1 + self._s1.moved(self._s2)
        self._credible, self._s1_at_s2, self._past = self._s2, moved, empty_line()
        return moved

    def _is_spike(self, value: float, expected: float) -> bool:
        """Return whether a sample is too far from where S1 was, unless so were many before it."""
        if not abs(value - expected) > self.parameters.s1.spike_threshold > 0.0:
            self._spikes = 0
            return False
        self._spikes = (self._spikes + 1) % (LONGEST_SPIKE + 1)
        return self._spikes > 0

    def _is_doubtful(self, off: float) -> bool:
        """Return whether a sample of S2 is too far from where S1 has moved, unless several agree.

        Args:
            off: How far.
        """
        limit = DOUBTFUL * self.parameters.signal.period
        has_moved, self._moved = self._moved, False
        if not (abs(off) > limit > 0.0 and has_moved):
            self._doubts = 0
            return False
        agrees = self._doubts > 0 and abs(off - self._off) <= limit
        self._off, self._doubts = off, self._doubts + 1 if agrees else 1
        return self._doubts < LASTING

    def _on_line(self, sample: Sample, value: float) -> Sample:
        self._s1.value, self._s1.s2 = bounded(value), self._s2
        if self.parameters.signal.period > 0.0 and self._behind > 0.0:
            self._past = extended(self._past, sample.stamp_ns, self._s1.value, self._behind)
        return sample._replace(value=self._s1.value)

    @property
    def _behind(self) -> float:
        """How old what S2 shows is, seconds."""
        s2 = self.parameters.s2
        return s2.delay + s2.lag_time_constant

    def _s1_shown(self, stamp_ns: int) -> float | None:
        """Return where S1 was at what a sample of S2 shows; None before its first sample."""
        if self._s1.value is None:
            return None
        return delayed(self._past, self._s1.stamp_ns, self._s1.value, stamp_ns, self._behind)

    def _near(self, value: float, expected: float) -> float:
        return nearest(value, expected, self.parameters.signal.period)


class Integrated(Unwrapped):
    """A rate: its trapezoidal integral, which passes through the first sample of S2.

    Over a silence beyond the timeout nothing is integrated: it moves as S2 has. Before a sample of
    S2 there is no line, but what S1 has measured is kept, since S2 is behind it. An angle that
    moves by more than a turn from one sample to the next has moved by garbage: whole turns of it
    are left out, or else S2, which is placed by how S1 has moved, would be these turns away from S1
    as the observer sees it, delayed.
    """

    def __init__(self, parameters: Parameters) -> None:
        super().__init__(parameters)
        self._early: deque[Sample] = deque(maxlen=EARLY)

    def on_s1(self, sample: Sample) -> Sample | None:
        """Integrate it."""
        self._moved = True
        dt = self._s1.step(sample.stamp_ns, self.parameters.s1.timeout)
        mean = self._s1.mean_rate(sample.value)
        if self._s2 is None:
            self._keep(sample, dt, mean)
            return None
        if self._s1.value is None:
            return self._on_line(sample, self._s2)
        if math.isinf(dt):
            return self._on_line(sample, self._followed(self._s1.value))
        return self._on_line(sample, self._s1.value + self._within_a_turn(dt * mean))

    def on_s2(self, sample: Sample) -> Sample:
        """Unwrap it; the first one sets where the line is."""
        on_line = super().on_s2(sample)
        if self._early and self._s1.value is None:
            before = [each for each in self._early if each.stamp_ns <= sample.stamp_ns]
            at_s2 = before[-1] if before else self._early[0]
            offset = on_line.value - at_s2.value
            shifted = [self._on_line(each, each.value + offset) for each in self._early]
            self._early = deque(shifted)
            self._s1_at_s2 = self._s1_shown(sample.stamp_ns)
        return on_line

    def early(self) -> Sequence[Sample]:
        """Return the samples of S1 before the first of S2, the oldest first."""
        early = tuple(self._early)
        self._early.clear()
        return early

    def _keep(self, sample: Sample, dt: float, mean: float) -> None:
        """Integrate from 0 until there is a line."""
        if math.isinf(dt):
            self._early.clear()
        value = 0.0
        if self._early:
            value = bounded(self._early[-1].value + self._within_a_turn(dt * mean))
        self._early.append(sample._replace(value=value))

    def _within_a_turn(self, step: float) -> float:
        period = self.parameters.signal.period
        return nearest(step, 0.0, period) if abs(step) > period > 0.0 else step

    def _near(self, value: float, expected: float) -> float:
        return super()._near(value, expected) if self.parameters.signal.period > 0.0 else value


def lines_for(parameters: Parameters) -> Lines:
    """Return what ``s1.kind`` and ``signal.period`` ask for."""
    if parameters.s1.kind == "rate":
        return Integrated(parameters)
    return Unwrapped(parameters) if parameters.signal.period > 0.0 else AsTheyAre(parameters)
