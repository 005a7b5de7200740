"""Reproduces the paper: Figures 6 to 23 and its claims, with the numbers behind them.

A claim holds when its whole 95 % interval is on its side of the bound, over all seeds and at
every point of a sweep. The exit status is 1 if a claim of the paper fails; targets are ours: they
are shown, but do not count.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import progress
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say
from fuzzy_fusion_ros.paper.claims_report import as_document, claims_table
from fuzzy_fusion_ros.paper.tables import FIGURES
from fuzzy_fusion_ros.plots.reproduction import Reproduction, reproduce

FIRST_SEED = 1000
"""The defaults of the fusion were found with smaller seeds."""


@command("reproduce")
def main(arguments: Sequence[str] | None = None) -> int:
    """Draw the figures, print the claims, and return whether all hold."""
    given = _parser().parse_args(arguments)
    done = reproduce(
        parameters=options.parameters_of(given),
        figures=given.figures,
        seeds=range(given.seed, given.seed + given.seeds),
        jobs=given.jobs,
        output=Path(given.output),
        progress=progress,
    )
    print(_tables(done), file=sys.stderr if given.json == "-" else sys.stdout)
    if given.json:
        options.write_json(as_document(*done), given.json)
    say("reproduce", f"{given.output}: figures and their numbers")
    return DONE if all(claim.holds for claim in done.claims) else FAILED


def _tables(done: Reproduction) -> str:
    tables = (
        claims_table(done.claims, "the paper's claim, and what the value is", "holds"),
        claims_table(done.targets, "our target, and what the value is", "met"),
    )
    return "\n\n".join(table for table in tables if table)


def _parser() -> options.Parser:
    parser = options.Parser("reproduce", __doc__)
    parser.add_argument(
        "--output",
        metavar="DIR",
        default="out/reproduce",
        help="where figures and tables go {out/reproduce}",
    )
    parser.add_argument(
        "--figures",
        metavar="LIST",
        type=figures_in,
        default=FIGURES,
        help="such as 6,9-11; only what they need is run {6-23}",
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
        default=len(os.sched_getaffinity(0)),
        help="threads; they change no result {one per core}",
    )
    options.add_params(parser)
    options.add_json(parser)
    return parser


def figures_in(text: str) -> tuple[int, ...]:
    """Return the figures that a list such as ``6,9-11`` names, rising.

    Raises:
        ArgumentTypeError: It is no such list, or names figures that there are not.
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
