# SPDX-License-Identifier: Apache-2.0
"""Parameters measured while the fusion runs, for users who have not tuned."""

from __future__ import annotations

from types import ModuleType
from typing import Any

from fuzzy_fusion_ros.core import estimator as given
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.self_tuning import estimator as measured


def estimator_for(parameters: Parameters) -> ModuleType:
    """Return the estimator for such parameters: with those given, or with measured ones.

    Both have ``initial_state``, ``observe_s2``, ``update`` and ``without_s1`` of one form.
    """
    return measured if parameters.self_tuning else given


def in_use(parameters: Parameters, state: Any) -> Parameters:
    """Return the parameters in use: those given, or those measured so far.

    Args:
        parameters: Those given.
        state: The state of their estimator.
    """
    used: Parameters = state.parameters if parameters.self_tuning else parameters
    return used
