# SPDX-License-Identifier: Apache-2.0
"""Kalman filter that models S2's lag, robust against outliers of either sensor.

States: the signal ``s``, its velocity ``v``, S1's bias ``b``, and two first-order lags in series
after the signal, ``f`` and ``g``; the second approximates a short delay. Signal and bias are
random walks, the velocity is a Gauss-Markov process; with a deviation of 0 there is none. S1
measures ``s + b``, S2 measures ``g``.
"""

from __future__ import annotations

from typing import NamedTuple

from fuzzy_fusion_ros.baselines.answers import estimated, waiting
from fuzzy_fusion_ros.baselines.noise import FINEST, robust_variance, variance_in_motion
from fuzzy_fusion_ros.baselines.parameters import KalmanLagParameters
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.core.estimator import Estimate
from fuzzy_fusion_ros.core.numerics import bounded, lag_gain, seconds_between
from fuzzy_fusion_ros.parameters.group import numbers


class States(NamedTuple):
    """A number for each state."""

    s: float
    v: float
    b: float
    f: float
    g: float


class Covariance(NamedTuple):
    """Covariance of the states, its upper triangle."""

    ss: float
    sv: float
    sb: float
    sf: float
    sg: float
    vv: float
    vb: float
    vf: float
    vg: float
    bb: float
    bf: float
    bg: float
    ff: float
    fg: float
    gg: float


class Gaussian(NamedTuple):
    """Mean and covariance of the states."""

    mean: States
    covariance: Covariance


class KalmanLag(NamedTuple):
    """State of the filter.

    Attributes:
        started: Whether there was a sample of S2, which initialises the signal.
        stamp_ns: Stamp of the newest sample.
        s2_ns: Stamp of the last sample of S2.
        s2: That sample.
        belief: Mean and covariance.
    """

    started: bool
    stamp_ns: int
    s2_ns: int
    s2: float
    belief: Gaussian


def kalman_lag(parameters: KalmanLagParameters) -> Method:
    """Return the method."""
    plain = numbers(parameters)
    state = KalmanLag(started=False, stamp_ns=0, s2_ns=0, s2=0.0, belief=first_belief(plain, 0.0))
    return Method(observe_s2, update, without_s1, plain, state)


def observe_s2(
    parameters: KalmanLagParameters, state: KalmanLag, stamp_ns: int, value: float
) -> KalmanLag:
    """Correct by a sample of S2; the first one initialises the signal and its lags."""
    s2 = bounded(value)
    if state.started:
        ahead = predict(parameters, state.belief, seconds_between(state.stamp_ns, stamp_ns))
        dt = seconds_between(state.s2_ns, stamp_ns)
        rate = bounded((s2 - state.s2) / dt) if dt > 0.0 else 0.0
        variance = variance_in_motion(parameters.s2_noise, parameters.s2_motion_noise, rate)
        p = ahead.covariance
        shared = States(s=p.sg, v=p.vg, b=p.bg, f=p.fg, g=p.gg)
        belief = correct(ahead, shared, shared.g, variance, s2 - ahead.mean.g)
    else:
        belief = first_belief(parameters, s2)
    return KalmanLag(
        started=True,
        stamp_ns=max(state.stamp_ns, stamp_ns),
        s2_ns=stamp_ns,
        s2=s2,
        belief=belief,
    )


def update(
    parameters: KalmanLagParameters, state: KalmanLag, stamp_ns: int, value: float
) -> tuple[Estimate, KalmanLag]:
    """Correct by a sample of S1 and estimate."""
    if not state.started:
        return waiting(), state
    ahead = predict(parameters, state.belief, seconds_between(state.stamp_ns, stamp_ns))
    p = ahead.covariance
    shared = States(s=p.ss + p.sb, v=p.sv + p.vb, b=p.sb + p.bb, f=p.sf + p.bf, g=p.sg + p.bg)
    belief = correct(
        ahead,
        shared,
        shared.s + shared.b,
        parameters.s1_noise * parameters.s1_noise,
        value - (ahead.mean.s + ahead.mean.b),
    )
    kept = KalmanLag(
        started=True,
        stamp_ns=max(state.stamp_ns, stamp_ns),
        s2_ns=state.s2_ns,
        s2=state.s2,
        belief=belief,
    )
    return estimated(belief.mean.s, 0.0, belief.covariance.ss), kept


def without_s1(parameters: KalmanLagParameters, state: KalmanLag, stamp_ns: int) -> Estimate:
    """Estimate at a sample of S2 that has been observed."""
    return estimated(state.belief.mean.s, 0.0, state.belief.covariance.ss)


def first_belief(parameters: KalmanLagParameters, s2: float) -> Gaussian:
    """Return the belief after the first sample of S2, as if the signal had rested there."""
    p = parameters.s2_noise * parameters.s2_noise
    vv = parameters.velocity_deviation * parameters.velocity_deviation
    bb = parameters.bias_deviation * parameters.bias_deviation
    return Gaussian(
        States(s=s2, v=0.0, b=0.0, f=s2, g=s2),
        Covariance(
            ss=p, sv=0.0, sb=0.0, sf=p, sg=p,
            vv=vv, vb=0.0, vf=0.0, vg=0.0,
            bb=bb, bf=0.0, bg=0.0,
            ff=p, fg=p,
            gg=p,
        ),
    )  # fmt: skip


def predict(parameters: KalmanLagParameters, belief: Gaussian, dt: float) -> Gaussian:
    """Propagate by ``dt`` seconds; a late sample does not propagate.

    In turn ``s += t v; v *= d; f += h (s - f); g += k (f - g)``, each exact while what drives it is
    constant, then the noise of the processes.
    """
    elapsed = max(dt, 0.0)
    lost = lag_gain(elapsed, parameters.velocity_time_constant)
    t = parameters.velocity_time_constant * lost
    d = 1.0 - lost
    h = lag_gain(elapsed, parameters.lag_time_constant)
    k = lag_gain(elapsed, parameters.second_lag_time_constant)
    mean, p = belief
    s = bounded(mean.s + t * mean.v)
    v = d * mean.v
    f = mean.f + h * (s - mean.f)
    g = mean.g + k * (f - mean.g)
    # s += t v
    ss = p.ss + t * (2.0 * p.sv + t * p.vv)
    sv = p.sv + t * p.vv
    sb = p.sb + t * p.vb
    sf = p.sf + t * p.vf
    sg = p.sg + t * p.vg
    # v *= d
    sv = d * sv
    vv = d * d * p.vv
    vb = d * p.vb
    vf = d * p.vf
    vg = d * p.vg
    # f += h (s - f)
    ff = (1.0 - h) * ((1.0 - h) * p.ff + 2.0 * h * sf) + h * h * ss
    sf = sf + h * (ss - sf)
    vf = vf + h * (sv - vf)
    bf = p.bf + h * (sb - p.bf)
    fg = p.fg + h * (sg - p.fg)
    # g += k (f - g)
    gg = (1.0 - k) * ((1.0 - k) * p.gg + 2.0 * k * fg) + k * k * ff
    sg = sg + k * (sf - sg)
    vg = vg + k * (vf - vg)
    bg = p.bg + k * (bf - p.bg)
    fg = fg + k * (ff - fg)
    # noise
    ss = ss + parameters.process_noise * parameters.process_noise * elapsed
    vv = vv + (1.0 - d * d) * (parameters.velocity_deviation * parameters.velocity_deviation)
    bb = p.bb + parameters.bias_noise * parameters.bias_noise * elapsed
    return Gaussian(
        States(s, v, mean.b, f, g),
        Covariance(ss, sv, sb, sf, sg, vv, vb, vf, vg, bb, bf, bg, ff, fg, gg),
    )


def correct(
    belief: Gaussian, shared: States, prior: float, variance: float, innovation: float
) -> Gaussian:
    """Correct by a scalar measurement.

    Args:
        belief: Before the measurement.
        shared: Covariance of each state with what is measured.
        prior: Variance of what is measured, before the measurement.
        variance: Squared scale of the measurement's noise.
        innovation: The measurement minus its expectation.
    """
    mean, p = belief
    known = max(prior, 0.0)
    finest = (p.ss + p.bb + p.ff + p.gg) / (FINEST * FINEST)
    away = bounded(innovation)
    total = known + robust_variance(max(variance, finest), known, away)
    s, v, b, f, g = shared
    gain = States(s / total, v / total, b / total, f / total, g / total)
    return Gaussian(
        States(
            s=bounded(mean.s + gain.s * away),
            v=bounded(mean.v + gain.v * away),
            b=bounded(mean.b + gain.b * away),
            f=bounded(mean.f + gain.f * away),
            g=bounded(mean.g + gain.g * away),
        ),
        Covariance(
            ss=max(p.ss - gain.s * s, 0.0),
            sv=p.sv - gain.s * v,
            sb=p.sb - gain.s * b,
            sf=p.sf - gain.s * f,
            sg=p.sg - gain.s * g,
            vv=max(p.vv - gain.v * v, 0.0),
            vb=p.vb - gain.v * b,
            vf=p.vf - gain.v * f,
            vg=p.vg - gain.v * g,
            bb=max(p.bb - gain.b * b, 0.0),
            bf=p.bf - gain.b * f,
            bg=p.bg - gain.b * g,
            ff=max(p.ff - gain.f * f, 0.0),
            fg=p.fg - gain.f * g,
            gg=max(p.gg - gain.g * g, 0.0),
        ),
    )
