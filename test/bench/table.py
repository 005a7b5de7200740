# SPDX-License-Identifier: Apache-2.0
"""The table that a benchmark prints."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable
from typing import NamedTuple


class Aim(NamedTuple):
    """What a figure is meant to be.

    Attributes:
        bound: The bound.
        holds: Compares a figure with it.
        sign: The comparison as printed.
        unit: Of the figure; empty for a ratio.
    """

    bound: float
    holds: Callable[[float, float], bool]
    sign: str
    unit: str = ""

    def __str__(self) -> str:
        """Return the aim as printed."""
        return f"{self.sign} {self.bound:g}{self.unit and ' ' + self.unit}"


def at_most(bound: float, unit: str = "") -> Aim:
    """Return the aim not to be above a bound."""
    return Aim(bound, operator.le, "≤", unit)


def at_least(bound: float, unit: str = "") -> Aim:
    """Return the aim not to be below a bound."""
    return Aim(bound, operator.ge, "≥", unit)


class Row(NamedTuple):
    """One line of the table.

    Attributes:
        what: What is measured.
        ours: Our figure, with its unit.
        against: The other figure, and whose it is.
        figure: What the aim is about, the ratio of both unless said otherwise.
        aim: The aim, if there is one.
    """

    what: str
    ours: str
    against: str
    figure: float
    aim: Aim | None = None


HEAD = "| what | ours | against | ratio | aim | met? |\n|---|---|---|---|---|---|"


def markdown(rows: Iterable[Row]) -> str:
    """Return rows as a Markdown table."""
    return "\n".join([HEAD, *map(line, rows)])


def line(row: Row) -> str:
    """Return a row as a line of a Markdown table."""
    unit = row.aim.unit if row.aim else ""
    figure = f"{row.figure:.3g}{unit and ' ' + unit}"
    met = "" if row.aim is None else "yes" if row.aim.holds(row.figure, row.aim.bound) else "**no**"
    return f"| {row.what} | {row.ours} | {row.against} | {figure} | {row.aim or ''} | {met} |"
