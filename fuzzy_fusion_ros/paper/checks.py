# SPDX-License-Identifier: Apache-2.0
"""Values checked against bounds: the paper's claims and our own targets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from fuzzy_fusion_ros.paper.results import Interval, Results
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Point

SYMBOLS = {"tau2": ("τ₂", "s"), "sigma1": ("σ₁", "rad"), "bias1": ("bias₁", "rad")}
"""Symbol and unit of what the sweeps vary."""


class CheckedClaim(NamedTuple):
    """A claim or target, and whether the runs support it.

    Attributes:
        figure: Number of the figure in the paper.
        claim: What is claimed.
        measure: Definition of the value, and the bound.
        holds: Whether it holds, ``None`` where there is no bound.
        value: The value.
        interval: Low and high end of its 95 % interval.
        where: The decisive point and method, empty where there is only one.
    """

    figure: int
    claim: str
    measure: str
    holds: bool | None
    value: float
    interval: tuple[float, float]
    where: str


class Measured(NamedTuple):
    """A value that may be checked against a bound.

    Attributes:
        text: Its definition, with its unit.
        interval: The value.
        where: The point and method it is from, empty where there is only one.
    """

    text: str
    interval: Interval
    where: str = ""


def above(figure: int, claim: str, measured: Measured, bound: float) -> CheckedClaim:
    """Return a claim that holds if the whole interval lies above the bound."""
    holds = measured.interval.low > bound
    return _checked(figure, claim, f"{measured.text} > {bound:g}", holds, measured)


def below(figure: int, claim: str, measured: Measured, bound: float) -> CheckedClaim:
    """Return a claim that holds if the whole interval lies below the bound."""
    holds = measured.interval.high < bound
    return _checked(figure, claim, f"{measured.text} < {bound:g}", holds, measured)


def mean_at_most(figure: int, claim: str, measured: Measured, bound: float) -> CheckedClaim:
    """Return a target that is met if the mean is at most the bound, whatever its interval."""
    holds = measured.interval.mean <= bound
    return _checked(figure, claim, f"{measured.text} ≤ {bound:g}", holds, measured)


def stated(figure: int, claim: str, measured: Measured) -> CheckedClaim:
    """Return a value without a bound."""
    return _checked(figure, claim, measured.text, None, measured)


def ratios(
    results: Results, quantity: str, method: str, rivals: Sequence[str], points: Sequence[Point]
) -> list[Measured]:
    """Return ``method``'s quantity over each rival's at each point, paired by seed."""
    return [
        Measured(
            f"{quantity.upper()} of {method} ÷ {rivals[0] if len(rivals) == 1 else 'rival'}",
            results.ratio(quantity, method, rival, point),
            place(point) if len(rivals) == 1 else f"{rival}, {place(point)}",
        )
        for point in points
        for rival in rivals
    ]


def place(point: Point) -> str:
    """Name a point by what differs from nominal, ``nominal`` if nothing does."""
    named = [
        f"{SYMBOLS[field][0]} = {value:g} {SYMBOLS[field][1]}"
        for field, value in point._asdict().items()
        if value != getattr(NOMINAL, field)
    ]
    return ", ".join(named) or "nominal"


def _checked(
    figure: int, claim: str, measure: str, holds: bool | None, measured: Measured
) -> CheckedClaim:
    mean, low, high = measured.interval
    return CheckedClaim(figure, claim, measure, holds, mean, (low, high), measured.where)
