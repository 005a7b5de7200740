# SPDX-License-Identifier: Apache-2.0
"""Fuses a fast, inaccurate sensor with an accurate, slow one: live on topics, offline on bags."""

from __future__ import annotations

import argparse
import importlib
import os
from collections.abc import Sequence
from typing import Any

from fuzzy_fusion_ros.cli import COMMANDS
from fuzzy_fusion_ros.cli.status import DONE, command
from fuzzy_fusion_ros.parameters.arguments import PROGRAM, Parser


@command(PROGRAM)
def main(arguments: Sequence[str] | None = None) -> int:
    """Run the verb that is named first with the arguments that follow."""
    parser = Parser("", __doc__)
    add_verbs(parser)
    if completing():
        import argcomplete

        argcomplete.autocomplete(parser)
    return run(parser, parser.parse_args(arguments))


def completing() -> bool:
    """Return whether a shell asks for completions."""
    return "_ARGCOMPLETE" in os.environ


def add_verbs(parser: argparse.ArgumentParser) -> None:
    """Add the verb and its arguments.

    They are passed on to the verb as they are, since nodes take those of ROS. Only for completion,
    every verb's own parser is imported.
    """
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    width = max(map(len, COMMANDS))
    lines = (f"  {name.ljust(width)}  {about}" for name, about in COMMANDS.items())
    parser.epilog = "\n".join(["verbs (VERB --help lists the options):", *lines])
    if completing():
        verbs = parser.add_subparsers(parser_class=argparse.ArgumentParser)
        for name in COMMANDS:
            parent = _module(name).command_line()
            verbs.add_parser(name, parents=[parent], add_help=False)
        return
    parser.add_argument("verb", metavar="VERB", nargs="?", choices=COMMANDS, help="see below")
    parser.add_argument("arguments", metavar="...", nargs=argparse.REMAINDER, help="its arguments")


def run(parser: argparse.ArgumentParser, given: argparse.Namespace) -> int:
    """Run the verb, or print the help if there is none; return the exit status."""
    if given.verb is None:
        parser.print_help()
        return DONE
    status: int = _module(given.verb).main(given.arguments)
    return status


def _module(name: str) -> Any:
    return importlib.import_module(f"fuzzy_fusion_ros.cli.{name}")
