# SPDX-License-Identifier: Apache-2.0
"""The options that commands have in common."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TypedDict

from fuzzy_fusion_ros.jobs.outputs import one_for_each, require_writable
from fuzzy_fusion_ros.offline.topics import ROLES, Topics
from fuzzy_fusion_ros.parameters.errors import UsageError
from fuzzy_fusion_ros.parameters.stdout import write_out
from fuzzy_fusion_ros.parameters.writing import writing

REPORT_SUFFIXES = (".html", ".htm")


class Window(TypedDict):
    """The span of a bag to read, seconds from its first message; ``None`` is no limit."""

    start: float | None
    end: float | None


def add_params(parser: argparse.ArgumentParser) -> None:
    """Add ``--params``."""
    parser.add_argument(
        "--params",
        metavar="FILE",
        help="ROS parameter YAML of fusion_node {the defaults}",
    )


def add_topics(parser: argparse.ArgumentParser) -> None:
    """Add ``--s1 --s2 --estimate --truth --field --channel``."""
    meanings = {"s1": "S1", "s2": "S2", "estimate": "the estimate", "truth": "the truth"}
    for role in ROLES:
        parser.add_argument(
            f"--{role}",
            metavar="TOPIC",
            help=f"topic of {meanings[role]} {{/{role}}}",
        )
    parser.add_argument(
        "--field",
        metavar="[TOPIC=]PATH",
        action="append",
        default=[],
        help="path of the number in the messages of a topic (its name, or s1, s2, estimate or "
        "truth), or of every topic whose type has it; can be repeated; for example "
        "/imu=linear_acceleration.x {the default of the type, such as point.x of PointStamped}",
    )
    parser.add_argument(
        "--channel",
        metavar="NAME",
        default="",
        help="channel to use, if --params defines several",
    )


def add_window(parser: argparse.ArgumentParser) -> None:
    """Add ``--start`` and ``--end``."""
    parser.add_argument(
        "--start",
        metavar="S",
        type=seconds,
        help="start this many seconds after the first message of the bag {0}",
    )
    parser.add_argument(
        "--end",
        metavar="S",
        type=seconds,
        help="end this many seconds after the first message of the bag {end of the bag}",
    )


def add_seed(parser: argparse.ArgumentParser, default: int = 0) -> None:
    """Add ``--seed``."""
    parser.add_argument(
        "--seed",
        metavar="N",
        type=_count,
        default=default,
        help=f"random seed; the same seed gives the same result {{{default}}}",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``."""
    parser.add_argument(
        "--json",
        metavar="FILE",
        help="write the result as JSON; - writes it to stdout and everything else to stderr",
    )


def add_plot(parser: argparse.ArgumentParser) -> None:
    """Add ``--plot``."""
    parser.add_argument(
        "--plot",
        metavar="FILE",
        help="draw a plot, in the format of its suffix: .png, .svg or .pdf",
    )


def add_report(parser: argparse.ArgumentParser) -> None:
    """Add ``--report``."""
    parser.add_argument(
        "--report",
        metavar="FILE.html",
        help="write a self-contained page to explore in a browser",
    )


def add_unit(parser: argparse.ArgumentParser) -> None:
    """Add ``--unit``."""
    parser.add_argument(
        "--unit",
        metavar="UNIT",
        help="unit of the signal, for example m/s^2 {that of the message type, if it has one}",
    )


def topics_of(arguments: argparse.Namespace) -> Topics:
    """Return the topics to read, and the paths of the numbers in their messages.

    Raises:
        UsageError: A field is given for a topic that is not read.
    """
    names = {role: _absolute(getattr(arguments, role) or f"/{role}") for role in ROLES}
    fields: dict[str, str] = {}
    for text in arguments.field:
        owner, equals, path = text.partition("=")
        if not equals or not (owner in ROLES or owner.startswith("/")):
            fields[""] = text  # a path with a look-up in it has an = too
            continue
        roles = [role for role in ROLES if owner in {role, names[role]}]
        if not roles:
            raise UsageError(
                f"--field {text!r}: topic {owner} is not read; the topics that are read: "
                f"{', '.join(names.values())}"
            )
        fields.update(dict.fromkeys(roles, path))
    return Topics(**names, fields=fields, channel=arguments.channel)


def other_topics(arguments: argparse.Namespace, roles: Sequence[str] = ROLES) -> dict[str, str]:
    """Return the topics of some roles that are not the defaults, by role."""
    topics = topics_of(arguments).by_role()
    return {role: topics[role] for role in roles if topics[role] != f"/{role}"}


def window_of(arguments: argparse.Namespace) -> Window:
    """Return the span to read.

    Raises:
        UsageError: It is empty.
    """
    start, end = arguments.start, arguments.end
    if end is not None and end <= (start or 0.0):
        raise UsageError(f"--end must be greater than --start, got {end:g} and {start or 0.0:g}")
    return {"start": start, "end": end}


def write_json(document: object, path: str) -> None:
    """Write a document to the file, or stdout, given by ``--json``.

    Raises:
        FusionError: The file cannot be written.
    """
    text = json.dumps(document, indent=2, allow_nan=False) + "\n"
    if path == "-":
        write_out(text)
        return
    with writing(path) as file:
        file.write_text(text, encoding="utf-8")


def require_results(
    arguments: argparse.Namespace, *inputs: str | None, more: Iterable[str] = ()
) -> None:
    """Check that the files of ``--json``, ``--plot`` and ``--report`` can be written.

    It is done before the work starts.

    Args:
        arguments: What was given.
        inputs: Files and directories that are read, which no result may overwrite.
        more: Further files that are written.

    Raises:
        FusionError: A file cannot be written, is an input, is named twice, or has a suffix that is
            no format.
    """
    given = vars(arguments)
    plot, report, bags = given.get("plot"), given.get("report"), given.get("bag", "")
    if report and Path(report).suffix not in REPORT_SUFFIXES:
        raise UsageError(f"--report: got {report!r}, expected a name that ends in .html")
    names = [bags] if isinstance(bags, str) else bags
    several = [each for path in (plot, report) if path for each in one_for_each(path, names)]
    require_writable(given["json"], *several, *more, inputs=inputs)
    if plot:
        from fuzzy_fusion_ros.plots.style import require_format  # takes time to import

        require_format(plot)


def number(low: float, high: float) -> Callable[[str], float]:
    """Return a type of arguments: a number between two limits, both allowed."""

    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(
                f"got {text!r}, expected a number from {low:g} to {high:g}"
            )
        return value

    return parse


seconds = number(0.0, 1e9)


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**32:
        raise argparse.ArgumentTypeError(f"got {text!r}, expected an integer from 0 to 2^32 - 1")
    return int(text)


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
