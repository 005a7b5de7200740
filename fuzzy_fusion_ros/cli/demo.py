# SPDX-License-Identifier: Apache-2.0
"""Scores a real drive, balances a pendulum over DDS, replays it bit for bit and scores it.

pendulum_node and fusion_node run in processes of their own and close the loop in lockstep. Their
recording is replayed through the same fusion offline, and the run is simulated in this process:
both must equal the live run bit for bit. Plots are written next to the bags.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.parameters.arguments import Parser

if TYPE_CHECKING:
    from fuzzy_fusion_ros.jobs.demo import DemoResult

METRICS = ("rmse", "mae", "max", "bias", "lag")
"""Those that fit a terminal; ``score`` shows all of them."""


@command("demo")
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo; return whether replay and simulation are the live run."""
    given = command_line().parse_args(arguments)
    from fuzzy_fusion_ros.jobs.demo import demo  # after parsing: takes time to import

    found = demo(given.output, seed=given.seed, progress=BARS)
    show(_report(found))
    for problem in found.differences:
        say("demo", f"not the live run: {problem}")
    if found.differences:
        return FAILED
    show("\nlive = replay = simulation, bit for bit: every estimate and its explanation")
    show(f"bags and plots are in {given.output}")
    return DONE


def _report(found: DemoResult) -> str:
    from fuzzy_fusion_ros.scoring.report import summary, table
    from fuzzy_fusion_ros.text.table import number_column, text_table

    columns = [
        ["balanced on", "", *(each.signal for each in found.loops)],
        number_column("IAE", "rad s", [each.iae for each in found.loops]),
        number_column("ITAE", "rad s^2", [each.itae for each in found.loops]),
    ]
    return "\n\n".join(
        (
            f"{summary(found.car)}\n{table(found.car, METRICS)}",
            "closed loop: how far the pendulum swings when balanced on each signal\n"
            + text_table(list(zip(*columns, strict=True)), headers=2),
            "open loop: how far each signal is from the angle that the estimate balances\n"
            f"{summary(found.pendulum)}\n{table(found.pendulum, METRICS)}",
        )
    )


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("demo", __doc__)
    parser.add_argument(
        "--output",
        metavar="DIR",
        default="out/demo",
        help="directory for bags and plots {out/demo}",
    )
    options.add_seed(parser)
    return parser
