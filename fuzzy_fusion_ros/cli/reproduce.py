# SPDX-License-Identifier: Apache-2.0
"""Reproduces the paper: Figures 6 to 23 and its claims, with the numbers behind them.

A claim holds if its whole 95 % interval is on its side of the bound, over all seeds and at every
point of a sweep. The exit status is 1 if one of the paper's claims fails. Our own targets are
shown as well, but do not affect the exit status.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.parameters.arguments import Parser

if TYPE_CHECKING:
    from fuzzy_fusion_ros.jobs.reproduce import Reproduction

FIGURES = range(6, 24)
FIRST_SEED = 1000
"""The defaults of the fusion were found with smaller seeds."""


@command("reproduce")
def main(arguments: Sequence[str] | None = None) -> int:
    """Draw the figures, print the claims, and return whether all of them hold."""
    given = command_line().parse_args(arguments)
    options.require_results(given, given.params)
    from fuzzy_fusion_ros.jobs.reproduce import reproduce  # after parsing: takes time to import
    from fuzzy_fusion_ros.tuning.search import usable_processors

    done = reproduce(
        given.output,
        figures=given.figures,
        seeds=range(given.seed, given.seed + given.seeds),
        jobs=given.jobs or usable_processors(),
        parameters=given.params,
        progress=BARS,
    )
    _report(done, given)
    return DONE if all(claim.holds for claim in done.claims) else FAILED


def _report(done: Reproduction, given: argparse.Namespace) -> None:
    from fuzzy_fusion_ros.paper.claims_report import as_document, claims_table

    tables = (
        claims_table(done.claims, "the paper's claim, and how it is measured", "holds"),
        claims_table(done.targets, "our target, and how it is measured", "met"),
    )
    show("\n\n".join(table for table in tables if table), on_stderr=given.json == "-")
    if given.json:
        options.write_json(as_document(*done), given.json)
    say("reproduce", f"figures and the numbers behind them are in {given.output}")


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("reproduce", __doc__)
    parser.add_argument(
        "--output",
        metavar="DIR",
        default="out/reproduce",
        help="directory for figures and tables {out/reproduce}",
    )
    parser.add_argument(
        "--figures",
        metavar="LIST",
        type=figures_in,
        default=tuple(FIGURES),
        help="figures to reproduce, for example 6,9-11 {6-23}",
    )
    parser.add_argument(
        "--seeds",
        metavar="N",
        type=_count(2, 10_000),
        default=20,
        help="runs of each method at each point {20}",
    )
    options.add_seed(parser, FIRST_SEED)
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=_count(1, 1024),
        help="threads; the result does not depend on it {one per core}",
    )
    options.add_params(parser)
    options.add_json(parser)
    return parser


def figures_in(text: str) -> tuple[int, ...]:
    """Return the figures in a list such as ``6,9-11``, rising.

    Raises:
        ArgumentTypeError: It is not such a list, or has figures that do not exist.
    """
    found: set[int] = set()
    for part in text.split(","):
        first, dash, last = part.partition("-")
        ends = (first, last) if dash else (first, first)
        if not all(end.isdecimal() and int(end) in FIGURES for end in ends):
            raise argparse.ArgumentTypeError(
                f"got {text!r}, expected figures from {FIGURES[0]} to {FIGURES[-1]}, such as 6,9-11"
            )
        found.update(range(int(ends[0]), int(ends[1]) + 1))
    return tuple(sorted(found))


def _count(low: int, high: int) -> Callable[[str], int]:
    def parse(text: str) -> int:
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(
                f"got {text!r}, expected an integer from {low} to {high}"
            )
        return int(text)

    return parse
