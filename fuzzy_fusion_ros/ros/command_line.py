# SPDX-License-Identifier: Apache-2.0
"""The command line of a node: help, parameter files, and ROS arguments."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

from fuzzy_fusion_ros.parameters.arguments import Parser
from fuzzy_fusion_ros.parameters.file import owners
from fuzzy_fusion_ros.parameters.group import Descriptor, Group, Value, descriptors
from fuzzy_fusion_ros.ros.process import Stop, run

USAGE = """\
%(prog)s [-h] [--params FILE]
       [--ros-args [-p NAME:=VALUE] [-r FROM:=TO] [--params-file FILE] ...]"""


def run_node(
    stop: Stop,
    parser: Parser,
    load: Callable[[], Callable[..., Any]],
    arguments: Sequence[str] | None,
) -> int:
    """Run a node as its executable; return the exit status.

    Args:
        stop: Has taken over the signals.
        parser: Of the node's own arguments, from :func:`node_parser`.
        load: Imports and returns the node's class.
        arguments: The command line without the program; that of the process unless given.

    Raises:
        FusionError: The arguments cannot be used, or the node gives up.
    """
    own, ros = split(sys.argv[1:] if arguments is None else list(arguments))
    given = parser.parse_args(own)
    ros = [*(word for path in given.params for word in ("--params-file", path)), *ros]
    paths = [path for flag, path in pairwise(ros) if flag == "--params-file"]
    for path in paths:
        owners(path)  # ROS would take several lines to say that it cannot be read
    run(stop, load, ["--ros-args", *ros] if ros else [], parameter_files=paths)
    return 0


def node_parser(name: str, about: str | None, topics: str, parameters: type[Group]) -> Parser:
    """Return the parser of a node's own arguments, which are not for ROS.

    Args:
        name: The executable.
        about: What it does.
        topics: Its topics and services, in lines for ``--help``.
        parameters: Its group of parameters.
    """
    parser = Parser(
        name,
        about,
        usage=USAGE,
        epilog=f"{topics}\n\nparameters:\n{table(parameters)}".replace("%", "%%"),
    )
    parser.add_argument(
        "--params",
        "--params-file",
        metavar="FILE",
        action="append",
        default=[],
        help="ROS parameter YAML; the same as --ros-args --params-file FILE",
    )
    return parser


def split(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the arguments of the program and those between ``--ros-args`` and ``--``."""
    own: list[str] = []
    ros: list[str] = []
    inside = False
    for argument in arguments:
        if argument == "--ros-args":
            inside = True
        elif inside and argument == "--":
            inside = False
        else:
            (ros if inside else own).append(argument)
    return own, ros


def table(parameters: type[Group]) -> str:
    """Return one entry per parameter: name, default, meaning, unit, range."""
    return "\n".join(_entry(*each) for each in descriptors(parameters))


def _entry(name: str, descriptor: Descriptor, default: Value) -> str:
    shown = str(default).lower() if isinstance(default, bool) else f"{default}"
    shown = "[]" if default == () else shown
    unit = f" {descriptor.unit}" if descriptor.unit else ""
    start = "; at start-up only" if descriptor.fixed else ""
    text = f"{descriptor.text}; {descriptor.range}{start}"
    head = f"  {name} {{{shown}{unit}}}"
    return head + "\n" + textwrap.fill(text, 79, initial_indent=" " * 6, subsequent_indent=" " * 6)
