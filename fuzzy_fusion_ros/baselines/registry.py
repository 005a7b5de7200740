# SPDX-License-Identifier: Apache-2.0
"""Every baseline by name: how to make it, and what a fit may move."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from fuzzy_fusion_ros.baselines.complementary import complementary
from fuzzy_fusion_ros.baselines.constant_weight import constant_weight
from fuzzy_fusion_ros.baselines.error_state import error_state
from fuzzy_fusion_ros.baselines.kalman import kalman
from fuzzy_fusion_ros.baselines.kalman_lag import kalman_lag
from fuzzy_fusion_ros.baselines.parameters import (
    BaselineParameters,
    ConstantWeightParameters,
    ErrorStateParameters,
    KalmanLagParameters,
    KalmanParameters,
)
from fuzzy_fusion_ros.batch.series import Method
from fuzzy_fusion_ros.parameters.group import flatten


class Baseline(NamedTuple):
    """A filter that a user would pick instead.

    Attributes:
        method: Makes the method.
        moved: Dotted names of the numbers that a fit moves. Where only ratios of noises matter,
            one of them is fixed.
        switches: Dotted names of the booleans of which a fit tries both values.
        scaled: Dotted names of the noises of which only the ratios determine the estimate; their
            common factor determines its standard deviation.
    """

    method: Callable[[BaselineParameters], Method]
    moved: tuple[str, ...] = ()
    switches: tuple[str, ...] = ()
    scaled: tuple[str, ...] = ()


def _fitted_with_drive(name: str) -> tuple[str, ...]:
    """Name what a fit moves of a Kalman filter with S2's lag, apart from what drives its signal."""
    drives = {"process_noise", "velocity_deviation", "velocity_time_constant"}
    return tuple(f"{name}.{each}" for each in flatten(KalmanLagParameters()) if each not in drives)


def _noises(name: str) -> tuple[str, ...]:
    """Name the noises of a Kalman filter without S2's lag."""
    return tuple(f"{name}.{each}" for each in flatten(KalmanParameters()) if each != "biased")


BASELINES: Mapping[str, Baseline] = MappingProxyType(
    {
        "s1": Baseline(lambda _: constant_weight(ConstantWeightParameters(1.0))),
        "s2": Baseline(lambda _: constant_weight(ConstantWeightParameters(0.0))),
        "average": Baseline(lambda _: constant_weight(ConstantWeightParameters(0.5))),
        "constant_weight": Baseline(
            lambda parameters: constant_weight(parameters.constant_weight),
            ("constant_weight.weight",),
        ),
        "complementary": Baseline(
            lambda parameters: complementary(parameters.complementary),
            ("complementary.time_constant",),
            ("complementary.s2_lags",),
        ),
        "complementary_lowpass": Baseline(
            lambda parameters: complementary(parameters.complementary_lowpass),
            ("complementary_lowpass.time_constant", "complementary_lowpass.lowpass_time_constant"),
            ("complementary_lowpass.s2_lags",),
        ),
        "kalman": Baseline(
            lambda parameters: kalman(parameters.kalman),
            ("kalman.s1_noise", "kalman.s2_noise"),
            scaled=_noises("kalman"),
        ),
        "kalman_bias": Baseline(
            lambda parameters: kalman(parameters.kalman_bias),
            ("kalman_bias.s1_noise", "kalman_bias.s2_noise", "kalman_bias.bias_noise"),
            scaled=_noises("kalman_bias"),
        ),
        "kalman_lag": Baseline(
            lambda parameters: kalman_lag(parameters.kalman_lag),
            ("kalman_lag.process_noise", *_fitted_with_drive("kalman_lag")),
        ),
        "kalman_lag_cv": Baseline(
            lambda parameters: kalman_lag(parameters.kalman_lag_cv),
            (
                "kalman_lag_cv.velocity_deviation",
                "kalman_lag_cv.velocity_time_constant",
                *_fitted_with_drive("kalman_lag_cv"),
            ),
        ),
        "error_state": Baseline(
            lambda parameters: error_state(parameters.error_state),
            tuple(f"error_state.{name}" for name in flatten(ErrorStateParameters())),
        ),
    }
)
"""In the order in which tables show them."""


def methods(parameters: BaselineParameters) -> dict[str, Method]:
    """Return every baseline's method by its name."""
    return {name: baseline.method(parameters) for name, baseline in BASELINES.items()}
