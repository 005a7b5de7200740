# SPDX-License-Identifier: Apache-2.0
"""What tune draws."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from tuning.quick import be_quick
from tuning.recordings import Made, Sensors, made

from fuzzy_fusion_ros.core.observer import observes
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.plots.names import difference_name
from fuzzy_fusion_ros.plots.tuning import plot_tuning, without_turns
from fuzzy_fusion_ros.tuning import Tuned, tune


@pytest.fixture(scope="module")
def recording() -> Made:
    """What is fitted to."""
    return made(Sensors(noise=0.1), seconds=20.0)


@pytest.fixture(scope="module")
def tuned(recording: Made) -> Tuned:
    """A fit."""
    with pytest.MonkeyPatch.context() as context:
        be_quick(context)
        return tune(recording.series, recording.truth)


def test_sets_surfaces_and_traces_are_in_it(tuned: Tuned, recording: Made, tmp_path: Path) -> None:
    plot_tuning(tuned, recording.series, "m/s^2", tmp_path / "fit.svg")
    text = (tmp_path / "fit.svg").read_text(encoding="utf-8")
    for part in (
        "small before",
        "large",
        f"{difference_name(observes(tuned.parameters))} / m/s²",
        "|dS2/dt| / (m/s²)/s",
        "W1, the weight of S1",
        "drift",
        "estimate before",
        "estimate after",
        "truth",
        "after, RMSE",
    ):
        assert f"<!-- {part}" in text
    assert "m/s^2" not in text


@pytest.mark.parametrize("period", [0.0, 2.0 * math.pi, 360.0])
def test_an_angle_is_drawn_without_its_turns(period: float) -> None:
    angle = np.linspace(0.0, 5.0 * (period or 1.0), 500)
    s2 = angle - 0.1 * (period or 1.0)
    wrapped = [x - period * np.round(x / period) if period else x for x in (angle, s2)]
    wrapped[1][:7] = np.nan
    drawn = without_turns(*wrapped, period)
    assert np.isfinite(drawn[7:]).all()
    assert np.abs(np.diff(drawn[7:]) - np.diff(angle[7:])).max() < 1e-9


def test_the_same_fit_gives_the_same_bytes(tuned: Tuned, recording: Made, tmp_path: Path) -> None:
    for name in ("one.png", "two.png"):
        plot_tuning(tuned, recording.series, "", tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()


def test_rules_that_never_decide_are_drawn_too(
    tuned: Tuned, recording: Made, tmp_path: Path
) -> None:
    lost = replace(Parameters(), {"s2.timeout": 0.001, "aggregator.drift.large": 0.0})
    series = recording.series._replace(s2_ns=recording.series.s2_ns - 10**9)
    blind = tuned._replace(
        parameters=lost, with_truth=False, target=np.where(tuned.counted, tuned.target, np.nan)
    )
    plot_tuning(blind, series, "", tmp_path / "fit.svg")
    text = (tmp_path / "fit.svg").read_text(encoding="utf-8")
    assert "<!-- drift: none is used" in text
    assert "<!-- reference" in text
