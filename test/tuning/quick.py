# SPDX-License-Identifier: Apache-2.0
"""Fits with few evaluations, for tests of what is around them."""

from __future__ import annotations

from typing import Any

import pytest

from fuzzy_fusion_ros.tuning import baselines, candidates, search
from fuzzy_fusion_ros.tuning.fit import Evaluations

STEPS = 4
"""Steps of least squares, of which a fit takes up to fifteen."""


def be_quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the optimiser try little; with a truth, least squares do the rest."""
    few = {True: Evaluations(1, 1, 1), False: Evaluations(20, 30, 20)}
    whole = search._least_squares

    def least_squares(residuals: Any, start: Any, steps: int) -> search.Minimum:
        return whole(residuals, start, min(steps, STEPS))

    monkeypatch.setattr(candidates, "EVALUATIONS", few)
    monkeypatch.setattr(baselines, "EVALUATIONS", 1)
    monkeypatch.setattr(search, "_least_squares", least_squares)
