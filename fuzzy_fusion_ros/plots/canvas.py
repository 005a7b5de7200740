# SPDX-License-Identifier: Apache-2.0
"""The layout of the paper's figures: panels, a title, and the legend below them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import AbstractPathEffect, withStroke

from fuzzy_fusion_ros.plots.names import COLOURS
from fuzzy_fusion_ros.plots.style import new_figure

OUTLINE = {COLOURS["no_drift"]: "#6E6600"}
"""Pale colours get an outline of this colour."""


class Canvas(NamedTuple):
    """A figure.

    Attributes:
        figure: The whole.
        panels: Axes to draw in.
        below: Axes for the legend.
    """

    figure: Figure
    panels: list[Axes]
    below: Axes


def canvas(layout: str, heights: Sequence[float], height_px: int) -> Canvas:
    """Return an empty figure.

    Args:
        layout: As for matplotlib's ``subplot_mosaic``; the last letter is the legend's.
        heights: Heights of the rows relative to one another.
        height_px: Height of the whole.
    """
    figure, (whole,) = new_figure(height_px=height_px)
    whole.remove()
    mosaic = figure.subplot_mosaic(layout, gridspec_kw={"height_ratios": heights})
    *panels, below = mosaic.values()
    below.axis("off")
    return Canvas(figure, panels, below)


def put_title(on: Canvas, title: str, text: str) -> None:
    """Write the title and, below it, the key figures."""
    on.figure.suptitle(f"{title}\n{text}", x=0.01, ha="left", fontsize=12)


def put_legend(on: Canvas, columns: int) -> None:
    """Write the legend of the first panel below all panels."""
    handles, labels = on.panels[0].get_legend_handles_labels()
    on.below.legend(handles, labels, loc="center", ncols=columns)


def outlined(colour: str, width: float) -> list[AbstractPathEffect]:
    """Return the path effects that make a line of this colour and width visible on white."""
    if colour not in OUTLINE:
        return []
    return [withStroke(linewidth=width + 1.0, foreground=OUTLINE[colour])]
