"""Checks the two sensors of a recording, before any filter: what they are like, what is wrong.

It looks at rates, gaps, stamps against arrival, clocks that are apart, lag, noise, sign, scale
(degrees for radians, g for m/s^2, km/h for m/s, Pa for hPa), a rate for a value, angles that wrap,
spikes and stuck values, and names the parameter or option that mends each. The exit status is 1 if
something is wrong.

Without topics it lists which numbers of the bag move together, with lag and scale, whatever their
topics and types are; /s1 and /s2 are checked then only if the bag has them.
"""

from __future__ import annotations

from collections.abc import Sequence

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.arguments import Parser


@command("check")
def main(arguments: Sequence[str] | None = None) -> int:
    """Check a bag; return whether nothing is wrong."""
    given = command_line().parse_args(arguments)
    topics, window = options.topics_of(given), options.window_of(given)
    options.require_results(given, given.bag, given.params)
    from fuzzy_fusion_ros.jobs.check import check  # after parsing: takes time to import

    result = check(
        given.bag,
        parameters=given.params,
        topics=None if topics == Topics() else topics,
        **window,
        progress=BARS,
    )
    for note in result.notes:
        say("check", f"{given.bag}: {note}")
    show(result.report(), on_stderr=given.json == "-")
    if given.json:
        options.write_json(result.as_json(), given.json)
    return DONE if result.is_fine else FAILED


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("check", __doc__)
    parser.add_argument("bag", metavar="BAG", help="rosbag2 directory or .mcap file")
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    options.add_json(parser)
    return parser
