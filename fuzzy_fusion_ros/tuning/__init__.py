"""Fitting to a recording: what the sensors are like, what to fit to, and how far to trust it.

Read in the order of ``tune``: ``characterise`` the sensors, take the truth or make a
``reference``, cross_validate the ``ladder`` of settings with ``fit`` and ``search``, and fit the
``baselines`` alike.
"""

from fuzzy_fusion_ros.tuning.baselines import fit_baselines
from fuzzy_fusion_ros.tuning.characterise import Characteristics, characterise
from fuzzy_fusion_ros.tuning.errors import TuneError
from fuzzy_fusion_ros.tuning.reference import reference_without_truth
from fuzzy_fusion_ros.tuning.tune import Tuned, tune

__all__ = [
    "Characteristics",
    "TuneError",
    "Tuned",
    "characterise",
    "fit_baselines",
    "reference_without_truth",
    "tune",
]
