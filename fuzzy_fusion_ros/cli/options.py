"""The options that mean the same in every command."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

from fuzzy_fusion_ros.cli.status import UsageError
from fuzzy_fusion_ros.offline.topics import ROLES, Topics
from fuzzy_fusion_ros.parameters.file import parameters_from
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Parser(argparse.ArgumentParser):
    """A parser whose errors are single lines."""

    def __init__(self, name: str, description: str | None) -> None:
        """Name the command and say what it does."""
        super().__init__(
            prog=name,
            description=description,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    def error(self, message: str) -> NoReturn:
        """Refuse the arguments.

        Raises:
            UsageError: Always.
        """
        raise UsageError(f"{message}; see {self.prog} --help")


def add_params(parser: argparse.ArgumentParser) -> None:
    """Add ``--params``."""
    parser.add_argument(
        "--params",
        metavar="FILE",
        help="ROS parameter YAML of fusion_node {the defaults}",
    )


def add_topics(parser: argparse.ArgumentParser) -> None:
    """Add ``--s1 --s2 --estimate --truth --field``."""
    meanings = {"s1": "S1", "s2": "S2", "estimate": "the estimate", "truth": "the truth"}
    for role in ROLES:
        parser.add_argument(
            f"--{role}",
            metavar="TOPIC",
            default=f"/{role}",
            help=f"topic of {meanings[role]} {{/{role}}}",
        )
    parser.add_argument(
        "--field",
        metavar="[TOPIC=]PATH",
        action="append",
        default=[],
        help="where the number is in the messages: of one topic (by its name, or s1, s2, estimate "
        "or truth), or of all whose type has the path; may be given several times; such as "
        "/imu=linear_acceleration.x {the type's own: point.x of PointStamped}",
    )


def add_window(parser: argparse.ArgumentParser) -> None:
    """Add ``--start`` and ``--end``."""
    parser.add_argument(
        "--start",
        metavar="S",
        type=_seconds,
        help="begin at this many seconds from the bag's first message {0}",
    )
    parser.add_argument(
        "--end", metavar="S", type=_seconds, help="end before this many {the bag's end}"
    )


def add_seed(parser: argparse.ArgumentParser, default: int = 0) -> None:
    """Add ``--seed``."""
    parser.add_argument(
        "--seed",
        metavar="N",
        type=_count,
        default=default,
        help=f"seed of everything random; the same seed gives the same result {{{default}}}",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """Add ``--json``."""
    parser.add_argument(
        "--json", metavar="FILE", help="write the result as JSON; - is stdout, and nothing else"
    )


def add_plot(parser: argparse.ArgumentParser) -> None:
    """Add ``--plot``."""
    parser.add_argument(
        "--plot", metavar="FILE", help="draw into a file: .png, .svg, .pdf, by its name"
    )


def parameters_of(arguments: argparse.Namespace) -> Parameters:
    """Return the fusion's parameters.

    Raises:
        ParameterError: The file cannot be used.
    """
    return parameters_from(arguments.params) if arguments.params else Parameters()


def topics_of(arguments: argparse.Namespace) -> Topics:
    """Return the topics to read and where their numbers are.

    Raises:
        UsageError: A field is given for a topic that is not read.
    """
    names = {role: _absolute(getattr(arguments, role)) for role in ROLES}
    fields: dict[str, str] = {}
    for text in arguments.field:
        owner, equals, path = text.partition("=")
        if not equals or not (owner in ROLES or owner.startswith("/")):
            fields[""] = text  # a path with a look-up in it has an = too
            continue
        roles = [role for role in ROLES if owner in {role, names[role]}]
        if not roles:
            raise UsageError(
                f"--field {text!r} is for topic {owner}, which is not read: read are "
                f"{', '.join(names.values())}"
            )
        fields.update(dict.fromkeys(roles, path))
    return Topics(**names, fields=fields)


def window_of(arguments: argparse.Namespace) -> tuple[float | None, float | None]:
    """Return the span to read, seconds from the bag's first message.

    Raises:
        UsageError: It is empty.
    """
    start, end = arguments.start, arguments.end
    if end is not None and end <= (start or 0.0):
        raise UsageError(f"--end {end:g} is not behind --start {start or 0.0:g}: nothing is left")
    return start, end


def write_json(document: object, path: str) -> None:
    """Write a document where ``--json`` says.

    Raises:
        UsageError: The file cannot be written.
    """
    text = json.dumps(document, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    if path == "-":
        print(text, end="")
        return
    with writing(path):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(text, encoding="utf-8")


def require_writable(*paths: str | None) -> None:
    """Make sure that results can be written, before work that takes long; leave nothing behind.

    Args:
        paths: Files as the options name them; ``None`` and ``-`` are none.

    Raises:
        UsageError: A file cannot be written.
    """
    for path in paths:
        if path is None or path == "-":
            continue
        target = Path(path)
        with writing(path):
            target.parent.mkdir(parents=True, exist_ok=True)
            was_there = target.exists()
            target.open("ab").close()
            if not was_there:
                target.unlink()


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Turn the failure to write a file into an error of the user's.

    Raises:
        UsageError: The file cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"{str(path)!r} cannot be written: {error.strerror or error}") from None


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


_seconds = number(0.0, 1e9)


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) >= 2**32:
        raise argparse.ArgumentTypeError(f"got {text!r}, expected an integer from 0 to 2^32 - 1")
    return int(text)


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"
