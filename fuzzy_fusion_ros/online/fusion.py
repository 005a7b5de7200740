"""The fusion of two streams: guards, trigger and estimator in one, for node and replay alike.

What happens is decided by the samples alone, in the order in which they are taken, so the same
samples always give the same estimates.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core.estimator import (
    WAITING,
    Estimate,
    fall_back_to_s2,
    initial_state,
    observe_s2,
    update,
)
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.trigger import Step, trigger_for
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Fused(NamedTuple):
    """An estimate with the stamp of the sample that it is for."""

    stamp_ns: int
    estimate: Estimate


class Fusion:
    """Takes samples of S1 and S2 as they come and gives estimates.

    Attributes:
        s1, s2: The guards, with the counts of what was admitted and dropped.
        restarts: How often time jumped back.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.s1 = Guard()
        self.s2 = Guard()
        self.restarts = 0
        self._state = initial_state(parameters)
        self._trigger = trigger_for(parameters)
        self._estimated_ns = 0

    @property
    def parameters(self) -> Parameters:
        """The parameters, replaced as a whole; the next sample sees the new ones."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: Parameters) -> None:
        other_rules = first_rules(parameters) != first_rules(self._parameters)
        self._parameters = parameters
        self._trigger.parameters = parameters
        if other_rules:
            fresh = initial_state(parameters).predictor
            self._state = self._state._replace(predictor=fresh)

    def reset(self) -> None:
        """Forget all samples; the counts stay."""
        self._state = initial_state(self._parameters)
        self._trigger = trigger_for(self._parameters)
        self._estimated_ns = 0
        self.s1.restart()
        self.s2.restart()

    def take_s1(self, sample: Sample, now_ns: int) -> Fused | None:
        """Take a sample of S1.

        Args:
            sample: The sample as it came, whatever it holds.
            now_ns: Time of receipt, nanoseconds on the clock of the stamps.

        Returns:
            The estimate that is due now, if any.
        """
        if not self._admits(self.s1, sample, now_ns):
            return None
        if self._state.started_ns == 0:
            self._state = self._state._replace(started_ns=sample.stamp_ns)
        return self._do(self._trigger.on_s1(sample))

    def take_s2(self, sample: Sample, now_ns: int) -> Fused | None:
        """Take a sample of S2; as :meth:`take_s1`."""
        if not self._admits(self.s2, sample, now_ns):
            return None
        return self._do(self._trigger.on_s2(sample))

    def tick(self) -> Fused | None:
        """Take a tick of the timer, for the trigger of that name."""
        return self._do(self._trigger.on_tick())

    def _admits(self, guard: Guard, sample: Sample, now_ns: int) -> bool:
        tolerance = min(self._parameters.s1.timeout, self._parameters.s2.timeout)
        future_tolerance = self._parameters.future_tolerance
        return guard.take(sample, now_ns, future_tolerance, tolerance, self._jump)

    def _jump(self) -> None:
        self.restarts += 1
        self.reset()

    def _do(self, step: Step) -> Fused | None:
        self.s1.drop(Drop.UNPAIRED, step.unpaired_s1)
        self.s2.drop(Drop.UNPAIRED, step.unpaired_s2)
        if step.s2 is not None:
            self._state = observe_s2(self._parameters, self._state, step.s2.stamp_ns, step.s2.value)
        if step.s1 is not None:
            return self._estimate(step.s1)
        if step.s2 is not None and self._lost_s1(step.s2.stamp_ns):
            return self._fused(step.s2.stamp_ns, fall_back_to_s2(self._state))
        return None

    def _estimate(self, s1: Sample) -> Fused | None:
        estimate, self._state = update(self._parameters, self._state, s1.stamp_ns, s1.value)
        return None if estimate.mode == WAITING else self._fused(s1.stamp_ns, estimate)

    def _fused(self, stamp_ns: int, estimate: Estimate) -> Fused | None:
        """Let estimates out in rising order of stamps only."""
        if stamp_ns <= self._estimated_ns:
            return None
        self._estimated_ns = stamp_ns
        return Fused(stamp_ns, estimate)

    def _lost_s1(self, stamp_ns: int) -> bool:
        heard_ns = self.s2.first_ns if self.s1.newest_ns is None else self.s1.newest_ns
        return seconds_between(heard_ns, stamp_ns) > self._parameters.s1.timeout


def first_rules(parameters: Parameters) -> tuple[int, int, float, float]:
    """Return what the predictor's first rules are made from: others start it anew."""
    predictor = parameters.predictor
    return predictor.samples, predictor.rules, predictor.slope, predictor.lead
