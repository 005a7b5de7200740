# SPDX-License-Identifier: Apache-2.0
"""All figures, reduced, on one sheet."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.image import imread

from fuzzy_fusion_ros.plots.style import new_figure

COLUMNS = 3
ROW_PX = 205
"""Height of a row, enough for a figure a third as wide as the sheet."""


def contact_sheet(pictures: Sequence[Path]) -> Figure:
    """Return a sheet of pictures, row by row; call this and save the result inside ``styled()``.

    Args:
        pictures: PNG files, at least one.
    """
    rows = -(-len(pictures) // COLUMNS)
    figure, axes = new_figure(rows, COLUMNS, height_px=rows * ROW_PX)
    for each in axes:
        each.axis("off")
    for each, picture in zip(axes, pictures, strict=False):
        each.imshow(imread(picture), aspect="equal", interpolation="antialiased")
    return figure
