# SPDX-License-Identifier: Apache-2.0
"""Triggers: which samples make a step of the estimator, and when.

Each takes admitted samples and returns the step that is due now: a sample of S2 to observe,
then one of S1 to estimate at; either may be missing.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable
from typing import NamedTuple, Protocol

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.core.silence import S1_TIMEOUT, S2_TIMEOUT, followed, timeout_for
from fuzzy_fusion_ros.parameters.fusion import Parameters

PENDING = 256
"""Most samples of each sensor that wait for a partner; the oldest are dropped first."""


class Step(NamedTuple):
    """What the estimator has to do now: observe S2, if any, then estimate at S1, if any.

    Attributes:
        s2: The sample to observe.
        s1: The sample to estimate at.
        unpaired_s1, unpaired_s2: Samples given up, because no partner can come any more.
        s2_alone: Whether to estimate at the sample of S2, because S1 is lost.
    """

    s2: Sample | None = None
    s1: Sample | None = None
    unpaired_s1: int = 0
    unpaired_s2: int = 0
    s2_alone: bool = False


NOTHING = Step()


class Trigger(Protocol):
    """When an estimate is due.

    Attributes:
        parameters: The parameters, replaced when they change.
    """

    parameters: Parameters

    def on_s1(self, sample: Sample) -> Step:
        """Take a sample of S1."""

    def on_s2(self, sample: Sample) -> Step:
        """Take a sample of S2."""

    def on_tick(self) -> Step:
        """Take a tick of the timer."""


class S1Trigger:
    """At every sample of S1, with the newest of S2 held."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def on_s1(self, sample: Sample) -> Step:
        """Estimate at it."""
        return Step(None, sample)

    def on_s2(self, sample: Sample) -> Step:
        """Observe it."""
        return Step(sample)

    def on_tick(self) -> Step:
        """Do nothing."""
        return NOTHING


class TimerTrigger:
    """At every tick, with the newest of both; a tick without a new S1 gives no estimate."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._newest: Sample | None = None

    def on_s1(self, sample: Sample) -> Step:
        """Hold it for the next tick."""
        self._newest = sample
        return NOTHING

    def on_s2(self, sample: Sample) -> Step:
        """Observe it."""
        return Step(s2=sample)

    def on_tick(self) -> Step:
        """Estimate at the newest S1."""
        newest, self._newest = self._newest, None
        return Step(s1=newest)


class PairTrigger:
    """When S1 and S2 of equal stamps have both come, in whatever order.

    While one sensor is silent past its timeout, the other is released alone.
    """

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters
        self._s1 = _Waiting(S1_TIMEOUT)
        self._s2 = _Waiting(S2_TIMEOUT)
        self._released_ns = -1

    def on_s1(self, sample: Sample) -> Step:
        """Estimate at it if its partner is there or S2 is lost."""
        self._s1.hear(sample)
        partner = self._s2.pop(sample.stamp_ns)
        if partner is not None:
            return self._release(sample.stamp_ns, Step(s2=partner, s1=sample))
        if self._s2.lost_at(sample.stamp_ns, self.parameters.s2.timeout):
            return self._release(sample.stamp_ns, Step(s1=sample))
        return Step(unpaired_s1=self._s1.keep(sample, self._released_ns))

    def on_s2(self, sample: Sample) -> Step:
        """Estimate at its partner if that is there, or let it through alone if S1 is lost."""
        self._s2.hear(sample)
        partner = self._s1.pop(sample.stamp_ns)
        if partner is not None:
            return self._release(sample.stamp_ns, Step(s2=sample, s1=partner))
        if self._s1.lost_at(sample.stamp_ns, self.parameters.s1.timeout):
            return self._release(sample.stamp_ns, Step(s2=sample))
        return Step(unpaired_s2=self._s2.keep(sample, self._released_ns))

    def on_tick(self) -> Step:
        """Do nothing."""
        return NOTHING

    def _release(self, stamp_ns: int, step: Step) -> Step:
        """Let a step out; what is older can pair no more."""
        s1 = self._s1.forget_before(stamp_ns)
        s2 = self._s2.forget_before(stamp_ns)
        self._released_ns = stamp_ns
        return step._replace(unpaired_s1=s1, unpaired_s2=s2)


class _Waiting:
    """Samples of one sensor that wait for their partners, oldest first."""

    def __init__(self, shortest_timeout: float) -> None:
        self._samples: OrderedDict[int, Sample] = OrderedDict()
        self._shortest_timeout = shortest_timeout
        self._interval = 0.0
        self._heard_ns: int | None = None
        self._spoke = False

    def hear(self, sample: Sample) -> None:
        if self._spoke and self._heard_ns is not None:
            dt = seconds_between(self._heard_ns, sample.stamp_ns)
            self._interval = followed(self._interval, dt)
        self._heard_ns, self._spoke = sample.stamp_ns, True

    def lost_at(self, stamp_ns: int, timeout: float) -> bool:
        if self._heard_ns is None:  # awaited from the other sensor's first sample on
            self._heard_ns = stamp_ns
        longest = timeout_for(timeout, self._shortest_timeout, self._interval)
        return seconds_between(self._heard_ns, stamp_ns) > longest

    def keep(self, sample: Sample, released_ns: int) -> int:
        """Keep a sample; return how many were given up on, be it this one for being late."""
        if sample.stamp_ns <= released_ns:
            return 1
        self._samples[sample.stamp_ns] = sample
        if len(self._samples) <= PENDING:
            return 0
        self._samples.popitem(last=False)
        return 1

    def pop(self, stamp_ns: int) -> Sample | None:
        return self._samples.pop(stamp_ns, None)

    def forget_before(self, stamp_ns: int) -> int:
        """Give up on what is older; return how many."""
        older = [stamp for stamp in self._samples if stamp < stamp_ns]
        for stamp in older:
            del self._samples[stamp]
        return len(older)


def trigger_for(parameters: Parameters) -> Trigger:
    """Return the trigger that ``parameters.trigger`` names."""
    kinds: dict[str, Callable[[Parameters], Trigger]] = {
        "s1": S1Trigger,
        "pair": PairTrigger,
        "timer": TimerTrigger,
    }
    return kinds[parameters.trigger](parameters)
