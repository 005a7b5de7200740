"""Runs a bag through the fusion into a new bag, or plays it onto topics with --live.

The new bag holds the input's messages, bytes unchanged, and after each what fusion_node would
have published because of it: the estimate (an old one is left out) and its explanation.

With --live the messages go onto their topics, but for old estimates, as soon as S1 and S2 have
subscribers; /clock follows the times of recording.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.cli import options
from fuzzy_fusion_ros.cli.progress import progress
from fuzzy_fusion_ros.cli.status import DONE, UsageError, command, say
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import explanation_prefix


@command("replay")
def main(arguments: Sequence[str] | None = None) -> int:
    """Replay a bag."""
    given = _parser().parse_args(arguments)
    return _play(given) if given.live else _replay(given)


def _replay(given: argparse.Namespace) -> int:
    if given.rate is not None or given.loop:
        raise UsageError("--rate and --loop are for --live: offline it runs as fast as it can")
    output = Path(given.output or f"{Path(given.bag).resolve().stem}_replay")
    start_s, end_s = options.window_of(given)
    with open_bag(given.bag) as bag:
        done = replay(
            bag,
            output,
            options.topics_of(given),
            options.parameters_of(given),
            start_s,
            end_s,
            lambda messages: progress(messages, "replay", bag.message_count, " messages"),
        )
    for note in done.notes:
        say("replay", note)
    if done.restarts:
        say("replay", f"time jumped back {done.restarts} times; the fusion began anew each time")
    print(f"{output}: {done.messages} messages copied, {done.estimates} estimates made")
    return DONE


def _play(given: argparse.Namespace) -> int:
    if given.output:
        raise UsageError("--output is for offline replays: --live writes nothing")
    topics = options.topics_of(given)
    start_s, end_s = options.window_of(given)
    with open_bag(given.bag) as bag:
        bag.require_topics(topics.s1, topics.s2)
        bag.require_messages_from(start_s)
        prefix = explanation_prefix(topics.estimate)
        kept = [
            each
            for name, each in bag.topics.items()
            if name != topics.estimate and not name.startswith(prefix)
        ]
        from fuzzy_fusion_ros.nodes.player import play  # needs ROS

        done = play(
            kept,
            lambda: bag.messages([each.name for each in kept], start_s, end_s),
            [topics.s1, topics.s2],
            rate=given.rate or 1.0,
            loop=given.loop,
        )
        problems = bag.problems
    for note in (*done.notes, *problems):
        say("replay", note)
    print(f"{done.messages} messages played")
    return DONE


def _parser() -> options.Parser:
    parser = options.Parser("replay", __doc__)
    parser.add_argument("bag", metavar="BAG", help="rosbag2 directory or .mcap")
    parser.add_argument(
        "--output", metavar="DIR", help="directory of the new bag {BAG's name and _replay, here}"
    )
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    live = parser.add_argument_group("live")
    live.add_argument(
        "--live", action="store_true", help="publish the messages, with /clock, instead"
    )
    live.add_argument(
        "--rate",
        metavar="X",
        type=options.number(1e-3, 1e6),
        help="seconds of the bag per second {1}",
    )
    live.add_argument("--loop", action="store_true", help="begin again at the end")
    return parser
