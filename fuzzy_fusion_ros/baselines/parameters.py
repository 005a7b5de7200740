# SPDX-License-Identifier: Apache-2.0
"""Parameters of the baselines: one definition for YAML, fit and Python, as for the fusion."""

from __future__ import annotations

from dataclasses import dataclass

from fuzzy_fusion_ros.parameters.group import Group, group, real, switch


@dataclass(frozen=True)
class ConstantWeightParameters(Group):
    """A constant weighted mean."""

    weight: float = real(0.5, "weight of S1; S2 has the rest", high=1.0)


@dataclass(frozen=True)
class ComplementaryParameters(Group):
    """First-order complementary filter."""

    time_constant: float = real(
        0.2, "S1 determines changes faster than this, S2 slower ones", unit="s"
    )
    lowpass_time_constant: float = real(
        0.0, "time constant of a low-pass on S1 before the filter; 0 is off", unit="s"
    )
    s2_lags: bool = switch(False, "whether S2's own lag replaces the filter's low-pass")


@dataclass(frozen=True)
class KalmanParameters(Group):
    """Kalman filter whose signal is a random walk; S1's bias is another one, or zero."""

    process_noise: float = real(
        0.1, "random walk of the signal, standard deviation after a second", unit="signal/s^0.5"
    )
    s1_noise: float = real(0.1, "standard deviation of S1's noise", unit="signal", low=1e-12)
    s2_noise: float = real(0.01, "standard deviation of S2's noise", unit="signal", low=1e-12)
    biased: bool = switch(False, "whether S1's bias is a state of the filter")
    bias_noise: float = real(
        0.0, "random walk of S1's bias, standard deviation after a second", unit="signal/s^0.5"
    )


@dataclass(frozen=True)
class KalmanLagParameters(Group):
    """Kalman filter that models S2's lag, and the signal's velocity if that has a deviation."""

    process_noise: float = real(
        0.1, "random walk of the signal, standard deviation after a second", unit="signal/s^0.5"
    )
    velocity_deviation: float = real(
        0.0, "standard deviation of the signal's velocity; 0 is off", unit="signal/s"
    )
    velocity_time_constant: float = real(
        0.0, "time constant with which the velocity fades", unit="s"
    )
    s1_noise: float = real(0.1, "scale of S1's noise", unit="signal", low=1e-12)
    s2_noise: float = real(0.01, "scale of S2's noise at rest", unit="signal", low=1e-12)
    s2_motion_noise: float = real(
        0.01, "scale of S2's noise in motion, in multiples of |dS2/dt|", unit="s"
    )
    bias_deviation: float = real(
        1.0, "standard deviation of S1's bias before any sample", unit="signal"
    )
    bias_noise: float = real(
        0.01, "random walk of S1's bias, standard deviation after a second", unit="signal/s^0.5"
    )
    lag_time_constant: float = real(0.2, "time constant of S2's lag", unit="s")
    second_lag_time_constant: float = real(
        0.1, "time constant of a second lag in a row, which stands for a delay", unit="s"
    )


@dataclass(frozen=True)
class ErrorStateParameters(Group):
    """Error-state filter: S1 propagates the signal, a Kalman filter learns S1's bias."""

    process_noise: float = real(
        1.0, "random walk of S1, standard deviation after a second", unit="signal/s^0.5"
    )
    velocity_deviation: float = real(1.0, "standard deviation of the slope of S1", unit="signal/s")
    velocity_time_constant: float = real(1.0, "time constant with which that slope fades", unit="s")
    s1_noise: float = real(0.1, "scale of S1's noise", unit="signal", low=1e-12)
    lag_time_constant: float = real(0.2, "time constant of S2's lag", unit="s")
    delay: float = real(0.1, "delay of S2", unit="s")
    s2_noise: float = real(0.01, "scale of S2's noise at rest", unit="signal", low=1e-12)
    s2_motion_noise: float = real(
        0.01, "scale of S2's noise in motion, in multiples of |dS2/dt|", unit="s"
    )
    bias_deviation: float = real(
        1.0, "standard deviation of S1's bias before any sample", unit="signal"
    )
    bias_noise: float = real(
        0.01, "random walk of S1's bias, standard deviation after a second", unit="signal/s^0.5"
    )
    slope_deviation: float = real(
        0.01, "standard deviation of the slope of S1's bias", unit="signal/s"
    )
    slope_time_constant: float = real(100.0, "time constant with which the slope fades", unit="s")


@dataclass(frozen=True)
class BaselineParameters(Group):
    """All baselines that have parameters, by their names."""

    constant_weight: ConstantWeightParameters = group(ConstantWeightParameters())
    complementary: ComplementaryParameters = group(ComplementaryParameters())
    complementary_lowpass: ComplementaryParameters = group(
        ComplementaryParameters(lowpass_time_constant=0.1)
    )
    kalman: KalmanParameters = group(KalmanParameters())
    kalman_bias: KalmanParameters = group(KalmanParameters(biased=True, bias_noise=0.01))
    kalman_lag: KalmanLagParameters = group(KalmanLagParameters())
    kalman_lag_cv: KalmanLagParameters = group(
        KalmanLagParameters(process_noise=0.0, velocity_deviation=1.0, velocity_time_constant=1.0)
    )
    error_state: ErrorStateParameters = group(ErrorStateParameters())
