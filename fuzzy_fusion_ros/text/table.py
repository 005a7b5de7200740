# SPDX-License-Identifier: Apache-2.0
"""Tables in plain text that fit a terminal, for every command that prints one.

Instead of tabulate because that neither splits nor wraps a table that is too wide, which is most
of what is here.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterator, Sequence

from fuzzy_fusion_ros.text.visible import visible

WIDTH = 80
GAP = "  "
BEST = "*"


def text_table(
    rows: Sequence[Sequence[str]], *, headers: int = 1, align: str = "", width: int = WIDTH
) -> str:
    """Lay rows out in columns, at most ``width`` wide.

    A table that is too wide has its last column wrapped, if that holds text (is aligned left).
    Otherwise its columns are split into several tables, one below the other, each of which
    repeats the first column.

    Args:
        rows: Cells by row, all rows equally long.
        headers: How many of the first rows are headers; headers are never wrapped.
        align: ``l`` or ``r`` for each column; unless given, the first is left and the rest right.
        width: Largest number of characters in a line.
    """
    rows = [list(map(visible, row)) for row in rows]
    align = align or "l" + "r" * (len(rows[0]) - 1)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if _width(widths) > width and align[-1] == "l":
        before = _width(widths[:-1]) + len(GAP)
        rows = [*rows[:headers], *_wrapped(rows[headers:], max(width - before, width // 4))]
        return "\n".join(_lines(rows, widths, align))
    tables = []
    for columns in _blocks(widths, width):
        cells = [[row[k] for k in columns] for row in rows]
        letters = "".join(align[k] for k in columns)
        tables.append("\n".join(_lines(cells, [widths[k] for k in columns], letters)))
    return "\n\n".join(tables)


def bag_table(rows: Sequence[tuple[str, ...]]) -> str:
    """Return a table of several bags: a row of headers, then one for each bag, words last."""
    shortened = [(_end_of(name), *rest) for name, *rest in rows]
    return text_table(shortened, align="l" + "r" * (len(rows[0]) - 2) + "l")


def _end_of(name: str, longest: int = 24) -> str:
    return name if len(name) <= longest else f"…{name[-longest + 1 :]}"


def number_column(head: str, unit: str, values: Sequence[float], *, digits: int = 4) -> list[str]:
    """Return a column of numbers below two headers, the smallest in magnitude marked.

    Args:
        head: First header.
        unit: Second header.
        values: The numbers; NaN is never marked.
        digits: Significant digits.
    """
    magnitudes = [abs(value) for value in values]
    best = min((each for each in magnitudes if not math.isnan(each)), default=None)
    marks = [BEST if each == best else " " * len(BEST) for each in magnitudes]
    cells = [f"{value:.{digits}g}{mark}" for value, mark in zip(values, marks, strict=True)]
    return [f"{head} ", f"{unit} ", *cells]


def _width(widths: Sequence[int]) -> int:
    return sum(widths) + len(GAP) * (len(widths) - 1)


def _wrapped(rows: Sequence[Sequence[str]], width: int) -> Iterator[Sequence[str]]:
    """Yield rows whose last cell is at most ``width`` wide; what is left follows below."""
    for *cells, last in rows:
        first, *rest = textwrap.wrap(last, width) or [""]
        yield [*cells, first]
        yield from ([*[""] * len(cells), each] for each in rest)


def _blocks(widths: Sequence[int], width: int) -> Iterator[list[int]]:
    """Yield the columns of each table: the first, and as many others as fit next to it."""
    block = [0]
    for k in range(1, len(widths)):
        if len(block) > 1 and _width([widths[j] for j in (*block, k)]) > width:
            yield block
            block = [0]
        block.append(k)
    yield block


def _lines(rows: Sequence[Sequence[str]], widths: Sequence[int], align: str) -> Iterator[str]:
    for row in rows:
        cells = [
            cell.ljust(width) if letter == "l" else cell.rjust(width)
            for cell, width, letter in zip(row, widths, align, strict=True)
        ]
        yield GAP.join(cells).rstrip()
