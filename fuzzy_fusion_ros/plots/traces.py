"""What ``score --plot`` draws: traces, errors, and what stands behind the estimate, over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fuzzy_fusion_ros.batch.arrays import Reals, root_mean_square
from fuzzy_fusion_ros.plots.style import COLOURS, NAMES, new_figure, save, styled, with_unit
from fuzzy_fusion_ros.scoring.score import Score

SHOWN = ("s1", "s2", "estimate")
"""What is drawn beside the truth; more would cover one another."""

COLUMNS = 1500
"""So many points along the time axis are drawn at most, each as the range that it stands for."""

CONSTANT = 1e-9
"""What varies by less is constant but for rounding."""


def plot_score(score: Score, path: str | Path) -> None:
    """Draw one recording into a file; weight and drift only where they are not constant.

    Args:
        score: The recording, scored.
        path: The file; its suffix names the format.

    Raises:
        FusionError: The file cannot be written or the format is unknown.
    """
    behind = [name for name, values in score.behind.items() if np.ptp(values) > CONSTANT]
    with styled():
        figure, axes = new_figure(rows=2 + len(behind), height_px=380 + 170 * len(behind) + 170)
        _draw_traces(axes[0], score)
        _draw_errors(axes[1], score)
        for each, name in zip(axes[2:], behind, strict=True):
            _draw(each, score.time_s, score.behind[name], "estimate", name)
            each.set_ylabel(with_unit(name, score.unit if name == "drift" else ""))
        axes[-1].set_xlabel("time / s")
        figure.suptitle(Path(score.name).name, fontsize="medium")
        save(figure, path)


def plot_paths(path: str | Path, scores: Sequence[Score]) -> list[Path]:
    """Return the files for several recordings: one as given, more with the bags' names added.

    Bags of one name in several folders are numbered, too.
    """
    given = Path(path)
    if len(scores) == 1:
        return [given]
    names = [Path(each.name).stem for each in scores]
    if len(set(names)) < len(names):
        names = [f"{number}_{name}" for number, name in enumerate(names, 1)]
    return [given.with_stem(f"{given.stem}_{name}") for name in names]


def _draw_traces(axes: Axes, score: Score) -> None:
    for name in SHOWN:
        _draw(axes, score.time_s, score.values[name], name, NAMES[name])
    _draw(axes, score.time_s, score.truth, "truth", NAMES["truth"])
    axes.set_ylabel(with_unit("signal", score.unit))
    _look_closer(axes, [score.truth, score.values["s2"], score.values["estimate"]])
    _legend_above(axes)


def _draw_errors(axes: Axes, score: Score) -> None:
    errors = {name: score.values[name] - score.truth for name in SHOWN}
    for name, error in errors.items():
        label = with_unit(f"{NAMES[name]}, RMSE {root_mean_square(error):.3g}", score.unit, " ")
        _draw(axes, score.time_s, error, name, label)
    axes.set_ylabel(with_unit("error", score.unit))
    _look_closer(axes, [errors["s2"], errors["estimate"]])
    _legend_above(axes)


def _draw(axes: Axes, time_s: Reals, values: Reals, name: str, label: str) -> None:
    """Draw a line; a long series as the band from the least to the largest in each column."""
    look: dict[str, Any] = {
        "color": COLOURS[name],
        "label": label,
        "alpha": 0.6 if name == "s1" else 1.0,
    }
    if time_s.size <= 2 * COLUMNS:
        axes.plot(time_s, values, **look)
        return
    starts = np.linspace(0, time_s.size, COLUMNS, endpoint=False).astype(np.int64)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    pairs = np.column_stack([low, high]).ravel()
    axes.plot(np.repeat(time_s[starts], 2), pairs, linewidth=0.8, **look)


def _legend_above(axes: Axes) -> None:
    legend = axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    for line in legend.get_lines():
        line.set(linewidth=2.0, alpha=1.0)


def _look_closer(axes: Axes, shown: Sequence[Reals]) -> None:
    """Set the limits by what matters; S1's noise may be cut."""
    values = np.concatenate(shown)
    low, high = np.quantile(values, [0.0005, 0.9995])
    margin = 0.2 * max(high - low, 1e-12)
    axes.set_ylim(low - margin, high + margin)
