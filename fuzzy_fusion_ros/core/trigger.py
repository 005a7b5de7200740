"""Triggers: which samples make a step of the estimator, and when.

Each takes admitted samples and answers with the step that is now due: samples of S2 to observe,
then at most one of S1 to estimate at.
"""

from __future__ import annotations

from collections import OrderedDict
from typing import NamedTuple, Protocol

from fuzzy_fusion_ros.core.clock import seconds_between
from fuzzy_fusion_ros.core.parameters import Parameters
from fuzzy_fusion_ros.core.sample import Sample

PENDING = 256
"""Samples of each sensor that wait for a partner at most; the oldest go first."""


class Step(NamedTuple):
    """What the estimator is to do now: observe S2, if any, then estimate at S1, if any."""

    s2: Sample | None = None
    s1: Sample | None = None
    unpaired: int = 0


NOTHING = Step()


class Trigger(Protocol):
    """When an estimate is due."""

    def on_s1(self, sample: Sample) -> Step:
        """Take a sample of S1."""

    def on_s2(self, sample: Sample) -> Step:
        """Take a sample of S2."""

    def on_tick(self) -> Step:
        """Take a tick of the timer."""


class S1Trigger:
    """At every sample of S1, with the newest of S2 held."""

    def on_s1(self, sample: Sample) -> Step:
        """Estimate at it."""
        return Step(s1=sample)

    def on_s2(self, sample: Sample) -> Step:
        """Observe it."""
        return Step(s2=sample)

    def on_tick(self) -> Step:
        """Do nothing."""
        return NOTHING


class TimerTrigger:
    """At every tick, with the newest of both; a tick without a new S1 gives no estimate."""

    def __init__(self) -> None:
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

    def __init__(self, s1_timeout: float, s2_timeout: float) -> None:
        self._s1 = _Waiting(s1_timeout)
        self._s2 = _Waiting(s2_timeout)

    def on_s1(self, sample: Sample) -> Step:
        """Estimate at it if its partner is there or S2 is lost."""
        partner, unpaired = _match(sample, self._s1, self._s2)
        if partner is not None:
            return Step(s2=partner, s1=sample, unpaired=unpaired)
        if self._s2.lost_at(sample.stamp_ns):
            return Step(s1=sample)
        return Step(unpaired=self._s1.keep(sample))

    def on_s2(self, sample: Sample) -> Step:
        """Estimate at its partner if that is there, or let it through alone if S1 is lost."""
        partner, unpaired = _match(sample, self._s2, self._s1)
        if partner is not None:
            return Step(s2=sample, s1=partner, unpaired=unpaired)
        if self._s1.lost_at(sample.stamp_ns):
            return Step(s2=sample)
        return Step(unpaired=self._s2.keep(sample))

    def on_tick(self) -> Step:
        """Do nothing."""
        return NOTHING


class _Waiting:
    """Samples of one sensor that wait for their partners, oldest first."""

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._samples: OrderedDict[int, Sample] = OrderedDict()
        self._heard_ns: int | None = None

    def hear(self, stamp_ns: int) -> None:
        self._heard_ns = stamp_ns

    def lost_at(self, stamp_ns: int) -> bool:
        if self._heard_ns is None:  # awaited from the other sensor's first sample on
            self._heard_ns = stamp_ns
        return seconds_between(self._heard_ns, stamp_ns) > self._timeout

    def keep(self, sample: Sample) -> int:
        """Keep a sample; return how many were pushed out."""
        self._samples[sample.stamp_ns] = sample
        if len(self._samples) <= PENDING:
            return 0
        self._samples.popitem(last=False)
        return 1

    def take(self, stamp_ns: int) -> Sample | None:
        return self._samples.pop(stamp_ns, None)

    def forget_before(self, stamp_ns: int) -> int:
        """Drop what is older; return how many."""
        older = [stamp for stamp in self._samples if stamp < stamp_ns]
        for stamp in older:
            del self._samples[stamp]
        return len(older)


def _match(sample: Sample, own: _Waiting, other: _Waiting) -> tuple[Sample | None, int]:
    """Return the partner of a sample, and how many older samples can have none any more."""
    own.hear(sample.stamp_ns)
    partner = other.take(sample.stamp_ns)
    if partner is None:
        return None, 0
    return partner, own.forget_before(sample.stamp_ns) + other.forget_before(sample.stamp_ns)


def trigger_for(parameters: Parameters) -> Trigger:
    """Return the trigger that ``parameters.trigger`` names."""
    if parameters.trigger == "pair":
        return PairTrigger(parameters.s1.timeout, parameters.s2.timeout)
    return TimerTrigger() if parameters.trigger == "timer" else S1Trigger()
