"""Runs a bag through the fusion into a new bag or, with --live, plays it onto its topics.

The new bag holds the messages of the old one, bytes unchanged, without an old estimate; after each
message comes what fusion_node would have published because of it: estimate and explanation.

With --live, every message but the old estimate is published on its topic as soon as S1 and S2 have
subscribers; /clock follows the times of recording.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.cli.status import DONE, command, say, show
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.parameters.errors import UsageError


@command("replay")
def main(arguments: Sequence[str] | None = None) -> int:
    """Replay a bag."""
    given = command_line().parse_args(arguments)
    return _play(given) if given.live else _replay(given)


def _replay(given: argparse.Namespace) -> int:
    if given.rate is not None or given.loop:
        raise UsageError("--rate and --loop require --live: offline, replay runs at full speed")
    output = Path(given.output or f"{Path(given.bag).resolve().stem}_replay")
    from fuzzy_fusion_ros.jobs.replay import replay  # after parsing: takes time to import
    from fuzzy_fusion_ros.online.mode_shares import in_words

    replayed = replay(
        given.bag,
        output,
        parameters=given.params,
        topics=options.topics_of(given),
        **options.window_of(given),
        progress=BARS,
    )
    for note in replayed.notes:
        say("replay", note)
    if replayed.restarts:
        times = "once" if replayed.restarts == 1 else f"{replayed.restarts} times"
        say("replay", f"timestamps jumped back {times}: state cleared, restarted")
    show(f"{output}: {replayed.messages} messages copied, {replayed.estimates} estimates written")
    show(f"modes: {in_words(replayed.modes)}")
    return DONE


def _play(given: argparse.Namespace) -> int:
    if given.output:
        raise UsageError("--output cannot be used with --live, which writes nothing")
    topics, window = options.topics_of(given), options.window_of(given)
    from fuzzy_fusion_ros.jobs.replay import play  # after parsing: takes time to import

    played = play(given.bag, topics=topics, **window, rate=given.rate or 1.0, loop=given.loop)
    for note in played.notes:
        say("replay", note)
    show(f"{played.messages} messages published")
    return DONE


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("replay", __doc__)
    parser.add_argument("bag", metavar="BAG", help="rosbag2 directory or .mcap file")
    parser.add_argument(
        "--output",
        metavar="DIR",
        help="directory of the new bag {the name of BAG with _replay appended, in the current one}",
    )
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    live = parser.add_argument_group("live")
    live.add_argument(
        "--live",
        action="store_true",
        help="publish the messages, and /clock, instead of writing a bag",
    )
    live.add_argument(
        "--rate",
        metavar="X",
        type=options.number(1e-3, 1e6),
        help="playback speed: seconds of the bag per second {1}",
    )
    live.add_argument("--loop", action="store_true", help="start over at the end of the bag")
    return parser
