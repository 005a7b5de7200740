# SPDX-License-Identifier: Apache-2.0
"""The filters that a user might choose instead, each a ``Method`` of ``batch.series``.

Pure functions over named tuples, like ``core``, so that replay, score and the closed loop run
them as they run the fuzzy estimator. All wait for the first sample of S2.
"""

from fuzzy_fusion_ros.baselines.complementary import complementary
from fuzzy_fusion_ros.baselines.constant_weight import constant_weight
from fuzzy_fusion_ros.baselines.defaults import baselines_for
from fuzzy_fusion_ros.baselines.error_state import error_state
from fuzzy_fusion_ros.baselines.kalman import kalman
from fuzzy_fusion_ros.baselines.kalman_lag import kalman_lag
from fuzzy_fusion_ros.baselines.parameters import (
    BaselineParameters,
    ComplementaryParameters,
    ConstantWeightParameters,
    ErrorStateParameters,
    KalmanLagParameters,
    KalmanParameters,
)
from fuzzy_fusion_ros.baselines.registry import BASELINES, Baseline, methods

__all__ = [
    "BASELINES",
    "Baseline",
    "BaselineParameters",
    "ComplementaryParameters",
    "ConstantWeightParameters",
    "ErrorStateParameters",
    "KalmanLagParameters",
    "KalmanParameters",
    "baselines_for",
    "complementary",
    "constant_weight",
    "error_state",
    "kalman",
    "kalman_lag",
    "methods",
]
