# SPDX-License-Identifier: Apache-2.0
"""Explains why the estimate at a given time is what it is, and which parameter would change it.

The fusion runs with --params from the first message of the bag; an estimate recorded in the bag is
ignored.
"""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.status import DONE, command, show
from fuzzy_fusion_ros.parameters.arguments import Parser


@command("explain")
def main(arguments: Sequence[str] | None = None) -> int:
    """Explain an estimate."""
    given = command_line().parse_args(arguments)
    topics = options.topics_of(given)
    from fuzzy_fusion_ros.jobs.explain import explain  # after parsing: takes time to import

    explained = explain(
        given.bag, given.at, parameters=given.params, topics=topics, unit=given.unit
    )
    show(f"At {explained.at_s:.3f} s: {explained.text}")
    return DONE


def command_line() -> Parser:
    """Return the parser of the command line."""
    parser = Parser("explain", __doc__)
    parser.add_argument("bag", metavar="BAG", help="rosbag2 directory or .mcap file")
    parser.add_argument(
        "--at",
        metavar="S",
        type=options.seconds,
        required=True,
        help="explain the newest estimate at this time, in seconds from the bag's first message",
    )
    options.add_params(parser)
    options.add_topics(parser)
    options.add_unit(parser)
    return parser
