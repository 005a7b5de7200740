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
class BaselineParameters(Group):
    """All baselines that have parameters, by their names."""

    constant_weight: ConstantWeightParameters = group(ConstantWeightParameters())
    complementary: ComplementaryParameters = group(ComplementaryParameters())
    complementary_lowpass: ComplementaryParameters = group(
        ComplementaryParameters(lowpass_time_constant=0.1)
    )
    kalman: KalmanParameters = group(KalmanParameters())
    kalman_bias: KalmanParameters = group(KalmanParameters(biased=True, bias_noise=0.01))
