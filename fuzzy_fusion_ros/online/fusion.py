# SPDX-License-Identifier: Apache-2.0
"""The fusion of two streams, for both node and replay: the intake decides, the estimator estimates.

What happens depends on the samples alone, in the order in which they come, so the same samples
always give the same estimates.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from fuzzy_fusion_ros.core.adaptation import Adaptation
from fuzzy_fusion_ros.core.estimator import WAITING, Estimate
from fuzzy_fusion_ros.core.periodic import turns
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.online.guard import Guard
from fuzzy_fusion_ros.online.intake import Intake
from fuzzy_fusion_ros.online.trigger import Step
from fuzzy_fusion_ros.online.verdict import Fused, Verdict
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.self_tuning import estimator_for, in_use

NOTHING_YET = Sample(0, 0.0)
"""Stands for S2 before its first sample."""


class Standing(NamedTuple):
    """Where a fusion stands between two samples.

    Attributes:
        state: The state of the estimator.
        estimated_ns: Stamp of the newest estimate, 0 before the first, nanoseconds.
        s2: The newest sample of S2, with its message.
    """

    state: Any
    estimated_ns: int
    s2: Sample


class Fusion:
    """Turns samples of S1 and S2, in order of arrival, into estimates.

    >>> from fuzzy_fusion_ros import Fusion, Parameters, Sample
    >>> fusion = Fusion(Parameters())
    >>> verdict = fusion.on_s2(Sample(stamp_ns=1_000_000_000, value=0.5))
    >>> verdict = fusion.on_s1(Sample(stamp_ns=1_000_000_000, value=0.5))
    >>> verdict.estimates[0].estimate.value
    0.5

    Attributes:
        restarts: How often timestamps jumped to a new timeline.
    """

    def __init__(self, parameters: Parameters) -> None:
        """Wait for samples.

        Raises:
            ParameterError: The parameters are those of several channels.
        """
        self._parameters = parameters = parameters.channel("")
        self._intake = Intake(parameters)
        self._estimator = estimator_for(parameters)
        self._state: Any = self._estimator.initial_state(parameters)
        self._estimated_ns = 0
        self._s2 = NOTHING_YET
        self.restarts = 0

    @property
    def s1(self) -> Guard:
        """The guard of S1, with the counts of what was admitted and dropped."""
        return self._intake.s1

    @property
    def s2(self) -> Guard:
        """The guard of S2."""
        return self._intake.s2

    @property
    def parameters(self) -> Parameters:
        """The parameters; assign new ones to use them from the next sample on."""
        return self._parameters

    @parameters.setter
    def parameters(self, parameters: Parameters) -> None:
        other_rules = first_rules(parameters) != first_rules(self._parameters)
        self._parameters = self._intake.parameters = parameters
        if other_rules:
            fresh = self._estimator.initial_state(parameters).predictor
            self._state = self._state._replace(predictor=fresh)

    @property
    def adaptation(self) -> Adaptation:
        """The factors adapted so far, of S2's lag and of S1's scale."""
        adaptation: Adaptation = self._state.sensors.belief.adaptation
        return adaptation

    @property
    def in_use(self) -> Parameters:
        """The parameters in use: those given, or with ``self_tuning`` those measured so far."""
        return in_use(self.parameters, self._state)

    def on_s1(self, sample: Sample, now_ns: int | None = None) -> Verdict:
        """Take a sample of S1.

        Args:
            sample: The sample as received, valid or not.
            now_ns: Receive time, nanoseconds on the clock of the stamps; the stamp unless
                given.

        Returns:
            Whether it was admitted, and the estimates that are due now.
        """
        now_ns = sample.stamp_ns if now_ns is None else now_ns
        return self._follow(self._intake.on_s1(sample, now_ns))

    def on_s2(self, sample: Sample, now_ns: int | None = None) -> Verdict:
        """Take a sample of S2; as :meth:`on_s1`."""
        now_ns = sample.stamp_ns if now_ns is None else now_ns
        return self._follow(self._intake.on_s2(sample, now_ns))

    def on_tick(self) -> Verdict:
        """Take a tick of the timer, for ``trigger: timer``."""
        return self._follow(self._intake.on_tick())

    def restart(self) -> Verdict:
        """Start a new timeline with the samples that are held, after the clock has jumped back."""
        return self._follow(self._intake.restart())

    def reset(self) -> None:
        """Clear the state; the counts are kept."""
        self._intake.reset()
        self._clear()

    def clock_problem(self) -> str:
        """Describe the offset between the sensors' clocks, ``""`` while it does no harm."""
        return self._intake.clock_problem()

    def is_settled(self) -> bool:
        """Return whether no sample is held, so that the next one is judged alone."""
        return self._intake.is_settled()

    @property
    def held_s2(self) -> float | None:
        """The newest value of S2, within the period if it has one; None before the first."""
        newest, period = self._intake.newest_s2, self.parameters.signal.period
        if newest is None or period == 0.0:
            return None if newest is None else newest.value
        return newest.value - period * turns(newest.value, 0.0, period)

    @property
    def standing(self) -> Standing:
        """The state between samples; assign one that the same samples have led to elsewhere."""
        return Standing(self._state, self._estimated_ns, self._s2)

    @standing.setter
    def standing(self, standing: Standing) -> None:
        self._state, self._estimated_ns, self._s2 = standing

    def finish(self) -> None:
        """Count the samples that are still held as dropped, at the end of the input."""
        self._intake.finish()

    def _clear(self) -> None:
        self._state = self._estimator.initial_state(self.parameters)
        self._estimated_ns = 0

    def _follow(self, verdict: Verdict) -> Verdict:
        """Do the steps of a verdict and add the estimates."""
        if verdict.restarted:
            self.restarts += 1
            self._clear()
        if self._state.started_ns == 0:
            self._state = self._state._replace(started_ns=self._intake.started_ns)
        for step in verdict.steps:
            verdict.estimates += self._do(step)
        return verdict

    def _do(self, step: Step) -> tuple[Fused, ...]:
        parameters = self._parameters
        s2, s1, _, _, s2_alone = step
        if s2 is not None:
            self._s2 = s2
            self._state = self._estimator.observe_s2(parameters, self._state, s2.stamp_ns, s2.value)
        if s1 is not None:
            estimate, self._state = self._estimator.update(
                parameters, self._state, s1.stamp_ns, s1.value
            )
            return self._fused(s1.stamp_ns, estimate)
        if s2 is not None and s2_alone:
            alone = self._estimator.without_s1(parameters, self._state, s2.stamp_ns)
            return self._fused(s2.stamp_ns, alone)
        return ()

    def _fused(self, stamp_ns: int, estimate: Estimate) -> tuple[Fused, ...]:
        """Let estimates out in rising order of stamps only."""
        if estimate.mode == WAITING or stamp_ns <= self._estimated_ns:
            return ()
        self._estimated_ns = stamp_ns
        period, turned = self._parameters.signal.period, 0.0
        if period > 0.0:
            turned = period * turns(estimate.value, 0.0, period)
            estimate = wrapped(estimate, turned)
        s2 = self._s2
        return (Fused(stamp_ns, estimate, self._state, s2.message, turned, s2.stamp_ns),)


def wrapped(estimate: Estimate, turned: float) -> Estimate:
    """Return an estimate with all that is behind it, turned back.

    Args:
        estimate: The estimate.
        turned: By how much: whole periods.
    """
    aggregate, prediction = estimate.aggregate, estimate.prediction
    if prediction.exists:
        prediction = prediction._replace(value=prediction.value - turned)
    return estimate._replace(
        value=estimate.value - turned,
        aggregate=aggregate._replace(value=aggregate.value - turned),
        prediction=prediction,
    )


def first_rules(parameters: Parameters) -> tuple[int, int, float, float]:
    """Return what the predictor's first rules are built from; if these change, it restarts."""
    predictor = parameters.predictor
    return predictor.samples, predictor.rules, predictor.slope, predictor.lead
