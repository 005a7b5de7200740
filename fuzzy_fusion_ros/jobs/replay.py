# SPDX-License-Identifier: Apache-2.0
"""Replays a bag: into a new bag, or onto topics."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from fuzzy_fusion_ros.bag import open_bag
from fuzzy_fusion_ros.jobs.parameter_file import Source, fusion_parameters
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.offline import replay as offline
from fuzzy_fusion_ros.offline.check import warnings_of
from fuzzy_fusion_ros.offline.replay import Replayed
from fuzzy_fusion_ros.offline.topics import Topics, explanation_prefix

if TYPE_CHECKING:
    from fuzzy_fusion_ros.nodes.player import Played


def replay(
    bag: str | Path,
    output: str | Path,
    *,
    parameters: Source = None,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    explanation: bool = True,
    progress: Progress = SILENT,
) -> Replayed:
    """Run a bag through the fusion into a new bag.

    The new bag holds the messages of the old one, byte for byte, except for an old estimate and
    its explanation. Each message is followed by what ``fusion_node`` would have published on
    receiving it, bit for bit.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file.
        output: Directory of the new bag, which must not exist.
        parameters: Of the fusion, or the YAML file with them; the defaults unless given.
        topics: Where the sensors are, and where the estimate goes; ``/s1``, ``/s2`` and
            ``/estimate`` unless given.
        start: Where to start, seconds from the first message of the bag.
        end: Where to end, seconds from the first message of the bag.
        explanation: Whether to write the explanation topics as well as the estimate.
        progress: Shows progress; none is shown unless given.

    Returns:
        How many messages were copied and estimates written, and what was dropped and why.

    Raises:
        FusionError: The bag, the parameters or the output cannot be used.
        KeyboardInterrupt: It says how much of the time the new bag holds.
    """
    wanted = topics or Topics()
    base = fusion_parameters(parameters).only(wanted.channel)
    with open_bag(bag) as reader:
        replayed = offline.replay(
            reader,
            output,
            wanted,
            base,
            start,
            end,
            progress.reading("replay", reader.message_count),
            explained=explanation,
        )
        try:
            found = [
                f"{name}: {each}" if name else each
                for name, own in base.by_channel().items()
                for each in warnings_of(reader, wanted, own, start, end)
            ]
        except KeyboardInterrupt:
            raise KeyboardInterrupt(f"{output} is complete") from None
    return replayed._replace(notes=(*replayed.notes, *found))


def play(
    bag: str | Path,
    *,
    topics: Topics | None = None,
    start: float | None = None,
    end: float | None = None,
    rate: float = 1.0,
    loop: bool = False,
    say: Callable[[str], None] = lambda _: None,
) -> Played:
    """Publish the messages of a bag on their topics, with ``/clock``; needs ROS.

    An old estimate and its explanation are left out.

    Args:
        bag: A rosbag2 directory or an ``.mcap`` file.
        topics: The topics that must have a subscriber before it starts.
        start: Where to start, seconds from the first message of the bag.
        end: Where to end, seconds from the first message of the bag.
        rate: Seconds of the bag per second.
        loop: Whether to start over at the end, until SIGINT or SIGTERM.
        say: Takes what a user is to know before the first message.

    Raises:
        FusionError: The bag cannot be used, or none of its types is installed.
        KeyboardInterrupt: A signal came before S1 and S2 had subscribers.
    """
    with open_bag(bag) as reader:
        wanted = (topics or Topics()).found_in(reader)
        wanted.require_in(reader)
        reader.require_messages_from(start)
        prefix = explanation_prefix(wanted.estimate)
        kept = [
            each
            for name, each in reader.topics.items()
            if name != wanted.estimate and not name.startswith(prefix)
        ]
        from fuzzy_fusion_ros.nodes.player import play as play_messages  # needs ROS

        if rate != 1.0:
            say(
                f"rate {rate:g}: run the node with use_sim_time:=true, or its timeouts count in "
                "wall time"
            )
        played = play_messages(
            kept,
            lambda: reader.messages([each.name for each in kept], start, end),
            [wanted.s1, wanted.s2],
            rate=rate,
            loop=loop,
        )
        return played._replace(notes=(*played.notes, *reader.problems))
