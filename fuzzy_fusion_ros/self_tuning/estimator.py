# SPDX-License-Identifier: Apache-2.0
"""The estimator with parameters that it measures itself: the same steps, and what they need.

Instead of numpy over a window of samples because it has to keep up with the sensors sample by
sample; state goes in and comes out as in :mod:`core.estimator`.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.core import estimator
from fuzzy_fusion_ros.core.adaptation import paused
from fuzzy_fusion_ros.core.delay_line import empty_line, extended
from fuzzy_fusion_ros.core.deviation import deviation
from fuzzy_fusion_ros.core.estimator import Estimate, Sensors, State
from fuzzy_fusion_ros.core.model import Shown
from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.observer import UNKNOWN
from fuzzy_fusion_ros.core.predictor import Predictor
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.self_tuning.choice import AT_ONCE, NO_LAG, chosen, first
from fuzzy_fusion_ros.self_tuning.lag_bank import FoundLag, LagBank, found_lag
from fuzzy_fusion_ros.self_tuning.measured import Measured, heard_s1, heard_s2, nothing_measured

ENOUGH = 16
"""Samples of S2 that have been compared with S1 before parameters are chosen."""

GROWTH, LONGEST_WAIT = 0.25, 256
"""They are updated after this share more samples, but at the latest after this many."""


class SelfTuned(NamedTuple):
    """Everything that is kept between samples.

    Attributes:
        sensors, predictor, started_ns: As the estimator's own state.
        measured: What has been measured.
        lag: S2's lag, as last found.
        due: Samples of S2 compared with S1 at which parameters are chosen next.
        given: The parameters given.
        parameters: The parameters in use.
    """

    sensors: Sensors
    predictor: Predictor
    started_ns: int
    measured: Measured
    lag: FoundLag
    due: int
    given: Parameters
    parameters: Parameters


def initial_state(parameters: Parameters) -> SelfTuned:
    """Return the state before any sample."""
    return SelfTuned(
        *estimator.initial_state(parameters),
        measured=nothing_measured(),
        lag=NO_LAG,
        due=ENOUGH,
        given=parameters,
        parameters=first(parameters),
    )


def observe_s2(parameters: Parameters, kept: SelfTuned, stamp_ns: int, value: float) -> SelfTuned:
    """Take a sample of S2; parameters may change after it."""
    kept = with_given(parameters, kept)
    state = estimator.observe_s2(kept.parameters, _own(kept), stamp_ns, value)
    measured = heard_s2(kept.measured, state.sensors, parameters.s1.timeout, stamp_ns, value)
    kept = _after(kept, state, measured)
    return adopted(kept) if measured.samples >= kept.due else kept


def update(
    parameters: Parameters, kept: SelfTuned, stamp_ns: int, value: float
) -> tuple[Estimate, SelfTuned]:
    """Take a sample of S1 and estimate, as :func:`core.estimator.update`."""
    kept = with_given(parameters, kept)
    estimate, state = estimator.update(kept.parameters, _own(kept), stamp_ns, value)
    estimate = _surely(kept, state.sensors, stamp_ns, estimate)
    measured = heard_s1(kept.measured, kept.sensors.s1, state.sensors.s1)
    return estimate, _after(kept, state, measured)


def without_s1(parameters: Parameters, kept: SelfTuned, stamp_ns: int) -> Estimate:
    """Return S2 alone as the estimate, as :func:`core.estimator.without_s1`."""
    estimate = estimator.without_s1(kept.parameters, _own(kept), stamp_ns)
    return _surely(kept, kept.sensors, stamp_ns, estimate)


def with_given(parameters: Parameters, kept: SelfTuned) -> SelfTuned:
    """Take note of given parameters that have changed; what is measured stays."""
    if parameters is kept.given:
        return kept
    in_use = first(parameters)
    if kept.measured.samples >= ENOUGH:
        in_use = chosen(parameters, kept.measured, kept.sensors, kept.lag)
    return kept._replace(given=parameters, parameters=in_use)


def adopted(kept: SelfTuned) -> SelfTuned:
    """Choose parameters by what has been measured and use them from the next sample on.

    The estimate does not jump: bias and conditioned S1 stay as they are.
    """
    measured, sensors, lag = kept.measured, kept.sensors, kept.lag
    if measured.bank is not None:
        span = measured.samples * sensors.s2.interval
        lag = found_lag(measured.bank, measured.errors, span, measured.late, lag)
        if lag.pair != kept.lag.pair:
            sensors = seen_through(measured.bank, lag, sensors)
    parameters = chosen(kept.given, measured, sensors, lag)
    sensors = on_the_scale_of(parameters, kept.parameters, sensors)
    if kept.parameters.s1.lowpass_time_constant <= 0.0:
        sensors = without_slope(sensors)
    wait = min(int(GROWTH * measured.samples), LONGEST_WAIT)
    return kept._replace(
        sensors=sensors, lag=lag, due=measured.samples + wait, parameters=parameters
    )


def seen_through(bank: LagBank, lag: FoundLag, sensors: Sensors) -> Sensors:
    """Start S2's model with another lag where S1 through that lag is."""
    line = extended(empty_line(), sensors.s1.stamp_ns, float(bank.second[lag.pair]), lag.delay)
    shown = Shown(float(bank.first[lag.pair]), line)
    states = sensors.belief.states._replace(shown=shown)
    belief = sensors.belief._replace(
        states=states, doubted=shown, adaptation=paused(sensors.belief.adaptation)
    )
    return sensors._replace(belief=belief)


def without_slope(sensors: Sensors) -> Sensors:
    """Start the low-pass on S1 without a slope: while it is off, that is the slope of noise."""
    smooth = sensors.s1.smooth._replace(slope=0.0)
    return sensors._replace(s1=sensors.s1._replace(smooth=smooth))


def on_the_scale_of(parameters: Parameters, before: Parameters, sensors: Sensors) -> Sensors:
    """Keep the size of S2's innovations where parameters change what is expected of them.

    Args:
        parameters: Those to come.
        before: Those so far.
        sensors: What is kept of the sensors.
    """
    evidence, interval = sensors.evidence, sensors.s2.interval
    change = _expected(before, interval) / _expected(parameters, interval)
    return sensors._replace(evidence=evidence._replace(variance=evidence.variance * change))


def _expected(parameters: Parameters, interval: float) -> float:
    """Return what the square of an innovation of S2 is about, in units of its noise variance."""
    steps = min(interval / parameters.s1.bias_time_constant, UNKNOWN)
    return 1.0 + steps * steps


def _surely(kept: SelfTuned, sensors: Sensors, stamp_ns: int, estimate: Estimate) -> Estimate:
    """Return an estimate with another standard deviation while S2 sets the bias at once.

    Its covariance then says nothing; what is known is how far S2 has been from what was expected
    of it, one interval after the last.
    """
    if kept.parameters.s1.bias_time_constant > AT_ONCE or estimate.standard_deviation == 0.0:
        return estimate
    interval = sensors.s2.interval
    age = seconds_between(sensors.s2.stamp_ns, stamp_ns)
    variance = sensors.belief.variance * (max(1.0, age / interval) if interval > 0.0 else 1.0)
    scale, floor = kept.parameters.estimate.deviation_scale, kept.parameters.s1.noise
    return estimate._replace(standard_deviation=deviation(scale, floor, sensors.evidence, variance))


def _own(kept: SelfTuned) -> State:
    return State(kept.sensors, kept.predictor, kept.started_ns)


def _after(kept: SelfTuned, state: State, measured: Measured) -> SelfTuned:
    """Return what is kept after a step, with the innovation of S2 if there is a new one."""
    belief = state.sensors.belief
    if belief.samples != kept.sensors.belief.samples and measured.samples >= ENOUGH:
        largest = max(measured.largest, abs(belief.innovation))
        measured = measured._replace(largest=largest)
    return kept._replace(
        sensors=state.sensors,
        predictor=state.predictor,
        started_ns=state.started_ns,
        measured=measured,
    )
