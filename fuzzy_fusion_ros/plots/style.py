# SPDX-License-Identifier: Apache-2.0
"""The style of every figure.

Importing this changes nothing in matplotlib; :func:`styled` does, for a while.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.writing import writing

WIDTH_PX = 900
_DPI = 100
_STYLE: dict[Any, Any] = {
    "font.size": 11.0,
    "axes.titlesize": 12.0,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "legend.frameon": False,
    "legend.fontsize": 10.0,
    "lines.linewidth": 1.4,
    "svg.hashsalt": "fuzzy_fusion_ros",
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the project's style inside the block."""
    with matplotlib.rc_context(_STYLE):
        yield


def new_figure(
    rows: int = 1,
    columns: int = 1,
    height_px: int = 500,
    *,
    heights: Sequence[float] | None = None,
    share_x: bool = True,
) -> tuple[Figure, list[Axes]]:
    """Return a figure as wide as a README shows it, and its axes row by row.

    Args:
        rows: Rows of axes.
        columns: Columns of axes.
        height_px: Height of the figure.
        heights: Relative heights of the rows; equal unless given.
        share_x: Whether the axes of a column share their x axis.
    """
    figure = Figure(figsize=(WIDTH_PX / _DPI, height_px / _DPI), dpi=_DPI, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(
        rows,
        columns,
        sharex="col" if share_x else False,
        squeeze=False,
        height_ratios=heights,
    )
    return figure, list(axes.flat)


def require_format(path: str | Path) -> None:
    """Reject a file whose suffix is not a known format.

    Raises:
        FusionError: The format is unknown.
    """
    formats = FigureCanvasAgg.get_supported_filetypes()
    if Path(path).suffix[1:] not in formats:
        raise FusionError(
            f"plot {str(path)!r} has an unknown format: use one of "
            + ", ".join(f".{each}" for each in sorted(formats))
        )


def save(figure: Figure, path: str | Path) -> None:
    """Write a figure into a file; the suffix is the format.

    The same figure always gives the same bytes.

    Raises:
        FusionError: The file cannot be written or the format is unknown.
    """
    target = Path(path)
    require_format(target)
    metadata = {"png": {"Software": None}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    with writing(target):
        figure.savefig(target, dpi=2 * _DPI, metadata=metadata.get(target.suffix[1:]))
