# SPDX-License-Identifier: Apache-2.0
"""Fits with few evaluations, for tests of what is around them."""

from __future__ import annotations

import pytest

from fuzzy_fusion_ros.tuning import baselines, candidates
from fuzzy_fusion_ros.tuning.fit import Evaluations


def be_quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the optimiser try little; with a truth, least squares do the rest."""
    few = {True: Evaluations(1, 1, 1), False: Evaluations(40, 60, 40)}
    monkeypatch.setattr(candidates, "EVALUATIONS", few)
    monkeypatch.setattr(baselines, "EVALUATIONS", 1)
