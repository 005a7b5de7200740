# SPDX-License-Identifier: Apache-2.0
"""Fitting parameters to a recording.

Read in the order of ``tune``: ``characterise`` the sensors, take the truth or make a
``reference``, fit every one of the ``candidates`` (``fit``, ``space``, ``search``), choose one by
cross-validation (``model_selection``), and fit the ``baselines`` by the same optimiser.
"""

from fuzzy_fusion_ros.tuning.baselines import fit_baselines
from fuzzy_fusion_ros.tuning.characterise import Characteristics, characterise
from fuzzy_fusion_ros.tuning.errors import TuneError
from fuzzy_fusion_ros.tuning.reference import reference_without_truth
from fuzzy_fusion_ros.tuning.tune import Trial, Tuned, tune, tune_to

__all__ = [
    "Characteristics",
    "Trial",
    "TuneError",
    "Tuned",
    "characterise",
    "fit_baselines",
    "reference_without_truth",
    "tune",
    "tune_to",
]
