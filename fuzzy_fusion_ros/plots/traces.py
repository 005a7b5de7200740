# SPDX-License-Identifier: Apache-2.0
"""What ``score --plot`` draws: traces, a close-up, errors, and the weight and drift behind them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from fuzzy_fusion_ros.batch.arrays import CONSTANT, Flags, Reals, root_mean_square
from fuzzy_fusion_ros.plots.close_up import close_up
from fuzzy_fusion_ros.plots.names import COLOURS, NAMES, with_unit
from fuzzy_fusion_ros.plots.style import new_figure, save, styled
from fuzzy_fusion_ros.scoring.score import Score
from fuzzy_fusion_ros.text.visible import visible

SHOWN = ("s1", "s2", "estimate")
"""What is drawn with the truth; more lines would hide one another."""

BEHIND = ("weight", "drift")
"""What is drawn of that which stands behind the estimate."""

COLUMNS = 1500
"""At most this many points along the time axis, each drawn as the range that it covers."""

STRETCHES = 150
"""Of how many stretches of time the RMS error is drawn."""


def plot_score(score: Score, path: str | Path) -> None:
    """Plot a scored recording.

    Weight and drift are drawn where they are known and not constant.

    Args:
        score: The recording, scored.
        path: The file; its suffix selects the format.

    Raises:
        FusionError: The file cannot be written or the format is unknown.
    """
    behind = [name for name in BEHIND if np.ptp(score.behind.get(name, 0.0)) > CONSTANT]
    heights = [260, 320, 240, *(150 for _ in behind)]
    with styled():
        figure, axes = new_figure(
            rows=len(heights), height_px=sum(heights) + 70, heights=heights, share_x=False
        )
        whole, near, errors, *rest = axes
        close = close_up(score.time_s, score.truth, score.values["s2"])
        _draw_traces(whole, score, np.ones_like(close))
        _draw_traces(near, score, close)
        whole.axvspan(*score.time_s[close][[0, -1]], color="#000000", alpha=0.08, linewidth=0)
        near.set_title("the shaded stretch", loc="left", fontsize="medium")
        _draw_errors(errors, score)
        for each, name in zip(rest, behind, strict=True):
            _draw(each, score.time_s, score.behind[name], "estimate", linewidth=0.8)
            each.set_ylabel(with_unit(name, score.unit if name == "drift" else ""))
        for each in (whole, errors, *rest):
            each.set_xlim(score.time_s[0], score.time_s[-1])
        axes[-1].set_xlabel("time / s")
        _legend_above(whole)
        figure.suptitle(visible(Path(score.name).name), fontsize="medium")
        save(figure, path)


def _draw_traces(axes: Axes, score: Score, where: Flags) -> None:
    time_s = score.time_s[where]
    _draw(axes, time_s, score.values["s1"][where], "s1", linewidth=0.6)
    _draw(axes, time_s, score.values["s2"][where], "s2", linewidth=2.0)
    _draw(axes, time_s, score.values["estimate"][where], "estimate", linewidth=1.4)
    _draw(axes, time_s, score.truth[where], "truth", linewidth=0.9)
    axes.set_ylabel(with_unit("signal", score.unit))
    axes.set_xlim(time_s[0], time_s[-1])


def _draw_errors(axes: Axes, score: Score) -> None:
    """Draw the RMS error over stretches of time, on a logarithmic scale, so that all are seen."""
    starts = np.unique(np.linspace(0, score.time_s.size, STRETCHES, endpoint=False).astype(int))
    counts = np.diff(np.append(starts, score.time_s.size))
    for name in SHOWN:
        error = score.values[name] - score.truth
        means = np.add.reduceat(np.square(error), starts) / counts
        label = with_unit(f"{NAMES[name]}, RMSE {root_mean_square(error):.3g}", score.unit, " ")
        axes.plot(
            score.time_s[starts], np.sqrt(means), color=COLOURS[name], label=label, linewidth=1.4
        )
    axes.set_yscale("log")
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.set_ylabel(with_unit("RMS error", score.unit))
    _legend_above(axes)


def _draw(axes: Axes, time_s: Reals, values: Reals, name: str, **look: Any) -> None:
    """Draw a line; a long series as the band from the least to the largest in each column."""
    look |= {"color": COLOURS[name], "label": NAMES[name]}
    if time_s.size <= 2 * COLUMNS:
        axes.plot(time_s, values, **look)
        return
    starts = np.linspace(0, time_s.size, COLUMNS, endpoint=False).astype(np.int64)
    low, high = np.minimum.reduceat(values, starts), np.maximum.reduceat(values, starts)
    pairs = np.column_stack([low, high]).ravel()
    axes.plot(np.repeat(time_s[starts], 2), pairs, **look)


def _legend_above(axes: Axes) -> None:
    legend = axes.legend(ncols=4, loc="lower left", bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2)
    for line in legend.get_lines():
        line.set(linewidth=2.0)
