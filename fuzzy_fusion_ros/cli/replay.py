# SPDX-License-Identifier: Apache-2.0
"""Runs a bag through the fusion into a new bag or, with --live, plays it onto its topics.

The new bag holds the messages of the old one, byte for byte, except an old estimate. Each message
is followed by what fusion_node would have published on receiving it: estimate and explanation.
With --no-explanation only the estimate is written, in less time and space.
Several bags give several new bags, in the directory --output. A bag that cannot be replayed gets a
row with the reason, and the exit status is 1.

With --live, every message except the old estimate is published on its topic once S1 and S2 have
subscribers; /clock follows the recorded times. At a --rate other than 1, run the node with
use_sim_time:=true, or its timeouts count in wall time.
"""

from __future__ import annotations

import argparse
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fuzzy_fusion_ros.cli import fleet, options
from fuzzy_fusion_ros.cli.status import DONE, FAILED, command, say, show
from fuzzy_fusion_ros.jobs.fleet import Failure
from fuzzy_fusion_ros.jobs.outputs import one_for_each
from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.parameters.errors import UsageError
from fuzzy_fusion_ros.text.table import bag_table

if TYPE_CHECKING:
    from fuzzy_fusion_ros.offline.replay import Replayed


@command("replay")
def main(arguments: Sequence[str] | None = None) -> int:
    """Replay one or several bags."""
    given = command_line().parse_args(arguments)
    return _play(given) if given.live else _replay(given)


def _replay(given: argparse.Namespace) -> int:
    if given.rate is not None or given.loop:
        raise UsageError("--rate and --loop require --live: offline, replay runs at full speed")
    topics, window = options.topics_of(given), options.window_of(given)
    task = functools.partial(
        _replay_to,
        parameters=fleet.absolute(given.params, given),
        topics=topics,
        **window,
        explanation=given.explanation,
        progress=fleet.progress_of(given),
    )
    bags = fleet.bags_of(given)
    outputs = [fleet.absolute(str(each), given) or "" for each in _outputs(bags, given.output)]
    items = {output: (bag, output) for bag, output in zip(bags, outputs, strict=True)}
    found = fleet.run(task, items, given)
    rows: list[tuple[str, ...]] = [("bag", "copied", "estimates", "new bag")]
    for bag, output, each in zip(bags, outputs, found, strict=True):
        if isinstance(each, Failure):
            rows.append(fleet.failed_row(bag, each, len(rows[0])))
            continue
        _say_notes(each, f"{bag}: " if len(found) > 1 else "")
        rows.append((bag, str(each.messages), str(each.estimates), output))
        if len(found) == 1:
            _show_one(output, each)
    if len(found) > 1:
        show(bag_table(rows))
    return FAILED if any(isinstance(each, Failure) for each in found) else DONE


def _outputs(bags: Sequence[str], given: str | None) -> list[Path]:
    """Return the new bags: of one bag as given, of several below the directory that is given."""
    if len(bags) == 1:
        return [Path(given or f"{Path(bags[0]).resolve().stem}_replay")]
    names = [str(Path(bag).resolve()) for bag in bags]
    return [
        each.with_name(f"{each.name.removeprefix('replay_')}_replay")
        for each in one_for_each(Path(given or ".", "replay"), names)
    ]


def _replay_to(item: tuple[str, str], **how: Any) -> Replayed:
    from fuzzy_fusion_ros.jobs.replay import replay  # after parsing: takes time to import

    bag, output = item
    return replay(bag, output, **how)


def _say_notes(replayed: Replayed, of: str) -> None:
    for note in replayed.notes:
        say("replay", f"{of}{note}")
    if replayed.restarts:
        times = "once" if replayed.restarts == 1 else f"{replayed.restarts} times"
        say("replay", f"{of}timestamps jumped back {times}: state cleared, restarted")


def _show_one(output: str, replayed: Replayed) -> None:
    from fuzzy_fusion_ros.online.mode_shares import in_words

    show(f"{output}: {replayed.messages} messages copied, {replayed.estimates} estimates written")
    show(f"modes: {in_words(replayed.modes)}")


def _play(given: argparse.Namespace) -> int:
    if given.output or not given.explanation:
        option = "--output" if given.output else "--no-explanation"
        raise UsageError(f"{option} cannot be used with --live, which writes nothing")
    if len(given.bag) > 1 or given.scheduler or given.jobs > 1:
        raise UsageError(
            "--live plays one bag in this process: give one BAG, without --jobs and --scheduler"
        )
    topics, window = options.topics_of(given), options.window_of(given)
    from fuzzy_fusion_ros.jobs.replay import play  # after parsing: takes time to import

    tell = functools.partial(say, "replay")
    rate = given.rate or 1.0
    played = play(given.bag[0], topics=topics, **window, rate=rate, loop=given.loop, say=tell)
    for note in played.notes:
        say("replay", note)
    show(f"{played.messages} messages published")
    return DONE


def command_line() -> Parser:
    """Return the parser of its arguments."""
    parser = Parser("replay", __doc__)
    fleet.add_bags(parser)
    parser.add_argument(
        "--output",
        metavar="DIR",
        help="directory of the new bag; for several bags, the directory to create theirs in "
        "{the name of BAG with _replay appended, in the current directory}",
    )
    options.add_params(parser)
    options.add_topics(parser)
    options.add_window(parser)
    parser.add_argument(
        "--no-explanation",
        dest="explanation",
        action="store_false",
        help="write the estimate without the topics that explain it",
    )
    live = parser.add_argument_group("live")
    live.add_argument(
        "--live",
        action="store_true",
        help="publish the messages and /clock instead of writing a bag",
    )
    live.add_argument(
        "--rate",
        metavar="X",
        type=options.number(1e-3, 1e6),
        help="playback speed: seconds of the bag per second {1}",
    )
    live.add_argument("--loop", action="store_true", help="restart at the end of the bag")
    return parser
