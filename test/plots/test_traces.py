# SPDX-License-Identifier: Apache-2.0
"""What score draws."""

from __future__ import annotations

import struct
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from bag.recorded import swing, write_scalars

from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.plots.style import new_figure
from fuzzy_fusion_ros.plots.traces import (
    COLUMNS,
    SHOWN,
    _draw,
    _draw_errors,
    _draw_traces,
    plot_score,
)
from fuzzy_fusion_ros.scoring.score import Score, score_bag


@pytest.fixture
def score(tmp_path: Path) -> Score:
    """A score with weight and drift."""
    path = write_scalars(tmp_path / "bag", swing(estimate=False))
    return score_bag(path, Topics(), Parameters())._replace(unit="m/s^2")


def size_of(path: Path) -> tuple[int, int]:
    """Return width and height of a PNG."""
    width, height = struct.unpack(">II", path.read_bytes()[16:24])
    return width, height


def test_a_file_is_drawn_at_twice_the_width_shown(score: Score, tmp_path: Path) -> None:
    plot_score(score, tmp_path / "all.png")
    plot_score(score._replace(behind={}), tmp_path / "less.png")
    assert size_of(tmp_path / "all.png")[0] == size_of(tmp_path / "less.png")[0] == 1800
    assert size_of(tmp_path / "all.png")[1] > size_of(tmp_path / "less.png")[1]


def test_pyplot_knows_nothing_of_it(score: Score, tmp_path: Path) -> None:
    before = plt.get_fignums()
    plot_score(score, tmp_path / "all.svg")
    assert plt.get_fignums() == before


def test_names_and_units_are_in_it(score: Score, tmp_path: Path) -> None:
    plot_score(score, tmp_path / "all.svg")
    text = (tmp_path / "all.svg").read_text(encoding="utf-8")
    for part in (
        "truth",
        "estimate, RMSE",
        "RMS error / m/s²",
        "weight",
        "drift / m/s²",
        "time / s",
    ):
        assert f"<!-- {part}" in text


def test_every_sensor_and_the_estimate_are_within_the_picture(score: Score) -> None:
    values = score.values["s1"].copy()
    values[[100, 200]] = [-50.0, 70.0]
    noisy = score._replace(values={**score.values, "s1": values})
    _, (traces, errors) = new_figure(rows=2)
    _draw_traces(traces, noisy, np.ones(values.size, bool))
    _draw_errors(errors, noisy)
    for axes, names in ((traces, ["S1", "S2", "estimate", "truth"]), (errors, SHOWN)):
        low, high = axes.get_ylim()
        lines = axes.get_lines()
        assert len(lines) == len(names)
        for line in lines:
            assert low <= np.min(line.get_ydata()) <= np.max(line.get_ydata()) <= high


def test_a_long_series_keeps_its_peaks() -> None:
    values = np.sin(np.arange(100_000) * 0.1)
    values[[1234, 77_777]] = [5.0, -7.0]
    _, (axes,) = new_figure()
    _draw(axes, np.arange(100_000) * 0.01, values, "s1")
    (line,) = axes.get_lines()
    drawn = np.asarray(line.get_ydata())
    assert drawn.size == 2 * COLUMNS
    assert (drawn.min(), drawn.max()) == (-7.0, 5.0)


def test_what_is_constant_but_for_rounding_is_not_drawn(score: Score, tmp_path: Path) -> None:
    weight = np.ones_like(score.time_s)
    weight[::2] -= 1e-15
    plot_score(score._replace(behind={"weight": weight}), tmp_path / "all.svg")
    assert "<!-- weight" not in (tmp_path / "all.svg").read_text(encoding="utf-8")
