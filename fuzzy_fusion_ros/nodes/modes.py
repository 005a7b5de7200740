# SPDX-License-Identifier: Apache-2.0
"""The mode of the fusion: which sensors its estimates stand on."""

from __future__ import annotations

import enum

from fuzzy_fusion_ros.core import estimator
from fuzzy_fusion_ros.ros.diagnostics import Level


class Mode(enum.Enum):
    """What the node does now."""

    WAITING = "waiting for both sensors"
    FUSED = "both sensors"
    S1_ONLY = "s2 timed out, using s1 alone"
    S2_ONLY = "s1 timed out, using s2 alone"
    STALE = "no sample of either sensor within its timeout, nothing is published"
    DISABLED = "disabled by ~/enable"
    INACTIVE = "activate the node to publish"

    @property
    def level(self) -> Level:
        """How bad that is."""
        if self is Mode.STALE:
            return Level.ERROR
        return Level.WARN if self in (Mode.S1_ONLY, Mode.S2_ONLY) else Level.OK


OF_ESTIMATE = {
    estimator.FUSED: Mode.FUSED,
    estimator.S1_ONLY: Mode.S1_ONLY,
    estimator.S2_ONLY: Mode.S2_ONLY,
}
"""The mode that an estimate shows."""
