# SPDX-License-Identifier: Apache-2.0
"""The page: a document of tables, charts and arrays, put into a template that draws it.

Charts are drawn by uPlot (uplot/, MIT), which is part of the page: a page needs no network.
"""

from __future__ import annotations

import base64
import html
import json
import zlib
from collections.abc import Mapping, Sequence
from importlib import resources
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.parameters.writing import writing

MOST_SAMPLES = 100_000
"""Of a longer recording every second, third, ... sample is shown: a browser draws no more well."""

SHARE_STEP = 1e-3
"""Weights and firing strengths are rounded to this, which halves their size."""

_TEMPLATE = "page.html"
_PARTS = {"@@uplot.css@@": "uplot/uPlot.min.css", "@@uplot.js@@": "uplot/uPlot.iife.min.js"}


class Line(NamedTuple):
    """A line of a chart.

    Attributes:
        series: Name of the array to draw.
        label: Its label.
        colour: ``#rrggbb``; black is drawn in the colour of the text.
        minus: Name of an array to subtract, if any.
        steps: Whether each value holds until the next.
        width: Width of the line, pixels.
    """

    series: str
    label: str
    colour: str
    minus: str = ""
    steps: bool = False
    width: float = 1.5


class Chart(NamedTuple):
    """A chart over time.

    Attributes:
        name: Its name in the page.
        title: What is drawn.
        unit: Unit of what is drawn, ``""`` for a plain number.
        lines: The lines.
        height: Height in pixels.
        shares: Whether what is drawn is from 0 to 1.
        band: Name of an array, if any: the band from minus to plus it is shaded.
    """

    name: str
    title: str
    unit: str
    lines: tuple[Line, ...]
    height: int = 180
    shares: bool = False
    band: str = ""


class Table(NamedTuple):
    """A table.

    Attributes:
        title: What it shows.
        head: Headers of the columns, one row or several.
        rows: Cells in plain text; ``*`` behind a number marks the best of a column.
    """

    title: str
    head: Sequence[Sequence[str]]
    rows: Sequence[Sequence[str]]


class Page(NamedTuple):
    """Everything on a page, in the order in which it is shown.

    Attributes:
        title: Title.
        lead: What was done, in a paragraph.
        notes: Remarks, one line each.
        tables: Tables.
        facts: What the sensors are like, one line each.
        modes: Share of time of each mode, 0 to 1, by name.
        time_s: Time of each sample, shape (n,), seconds.
        series: What is drawn over time by name, shape (n,) each, NaN where unknown.
        charts: Charts over time; they share cursor and zoom.
        rules: What :func:`rules.rule_base` returns.
        parameters: The parameter file.
    """

    title: str
    lead: str
    notes: Sequence[str]
    tables: Sequence[Table]
    facts: Sequence[str]
    modes: Mapping[str, float]
    time_s: Reals
    series: Mapping[str, Reals]
    charts: Sequence[Chart]
    rules: Mapping[str, Any]
    parameters: str


def write_page(page: Page, path: str | Path) -> None:
    """Write a page into a file.

    Raises:
        FusionError: The file cannot be written.
    """
    with writing(path) as file:
        file.write_text(rendered(page), encoding="utf-8")


def rendered(page: Page) -> str:
    """Return a page as HTML that needs nothing else."""
    folder = resources.files(__package__)
    text = (folder / _TEMPLATE).read_text(encoding="utf-8")
    text = text.replace("@@title@@", html.escape(page.title))
    for mark, name in _PARTS.items():
        text = text.replace(mark, (folder / name).read_text(encoding="utf-8"))
    document = json.dumps(_document(page), allow_nan=False)
    return text.replace("@@data@@", document.replace("<", "\\u003c"))


def _document(page: Page) -> dict[str, Any]:
    every = -(-page.time_s.size // MOST_SAMPLES)
    time_s = page.time_s[::every]
    notes = list(page.notes)
    if every > 1:
        notes.append(f"one sample in {every} is shown; the scores use all of them")
    return {
        "title": page.title,
        "lead": page.lead,
        "notes": notes,
        "tables": [each._asdict() for each in page.tables],
        "facts": list(page.facts),
        "modes": dict(page.modes),
        "start_s": float(time_s[0]),
        "steps": packed(np.diff(time_s, prepend=time_s[0])),
        "series": {name: packed(values[::every]) for name, values in page.series.items()},
        "charts": [
            {**each._asdict(), "lines": [line._asdict() for line in each.lines]}
            for each in page.charts
        ],
        "rules": page.rules,
        "parameters": page.parameters,
    }


def packed(values: Reals) -> str:
    """Return an array as text: single precision, bytes by significance, deflated, base64.

    Bytes of equal significance resemble one another, so that they deflate better side by side.
    """
    singles: NDArray[np.float32] = values.astype("<f4")
    planes = singles.view(np.uint8).reshape(-1, 4).T.tobytes()
    return base64.b64encode(zlib.compress(planes, 9)).decode("ascii")


def shares(values: Reals) -> Reals:
    """Return numbers from 0 to 1 rounded as they are shown."""
    return np.round(values / SHARE_STEP) * SHARE_STEP
