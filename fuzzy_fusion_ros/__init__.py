# SPDX-License-Identifier: Apache-2.0
"""Fuzzy fusion of a fast, inaccurate sensor with an accurate, slow one.

The names below are the Python interface, together with :mod:`fuzzy_fusion_ros.testing`; everything
else is private and may change. None of them needs ROS. Each is imported when it is first used.

>>> from fuzzy_fusion_ros import Parameters, replace
>>> parameters = replace(Parameters(), {"s1.lowpass_time_constant": 0.05})
>>> parameters.s1.lowpass_time_constant
0.05
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fuzzy_fusion_ros.bag.reader import open_bag
    from fuzzy_fusion_ros.core.sample import Sample
    from fuzzy_fusion_ros.jobs.check import check
    from fuzzy_fusion_ros.jobs.fuse import fuse
    from fuzzy_fusion_ros.jobs.replay import replay
    from fuzzy_fusion_ros.jobs.score import score
    from fuzzy_fusion_ros.jobs.tune import tune
    from fuzzy_fusion_ros.offline.topics import Topics
    from fuzzy_fusion_ros.online.fusion import Fusion
    from fuzzy_fusion_ros.parameters.errors import FusionError
    from fuzzy_fusion_ros.parameters.file import parameters_from
    from fuzzy_fusion_ros.parameters.fusion import Parameters
    from fuzzy_fusion_ros.parameters.group import replace
    from fuzzy_fusion_ros.plots.traces import plot_score

__all__ = [
    "Fusion",
    "FusionError",
    "Parameters",
    "Sample",
    "Topics",
    "check",
    "fuse",
    "open_bag",
    "parameters_from",
    "plot_score",
    "replace",
    "replay",
    "score",
    "tune",
]

_HOMES = {
    "Fusion": "online.fusion",
    "FusionError": "parameters.errors",
    "Parameters": "parameters.fusion",
    "Sample": "core.sample",
    "Topics": "offline.topics",
    "check": "jobs.check",
    "fuse": "jobs.fuse",
    "open_bag": "bag.reader",
    "parameters_from": "parameters.file",
    "plot_score": "plots.traces",
    "replace": "parameters.group",
    "replay": "jobs.replay",
    "score": "jobs.score",
    "tune": "jobs.tune",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used.

    Raises:
        AttributeError: There is no such name.
    """
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """List the public names."""
    return sorted(__all__)
