# SPDX-License-Identifier: Apache-2.0
"""The parser of every command line, for nodes and offline programs."""

from __future__ import annotations

import argparse
import sys
import textwrap
from pathlib import Path
from typing import Any, NoReturn

from fuzzy_fusion_ros.parameters.errors import UsageError
from fuzzy_fusion_ros.parameters.stdout import write_out
from fuzzy_fusion_ros.text.table import WIDTH

PROGRAM = "fuzzy-fusion"
"""The one program that an installation puts on PATH."""


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in a single line."""

    def __init__(self, name: str, description: str | None, **options: Any) -> None:
        """Create a parser.

        Args:
            name: The command; empty for the program of all commands.
            description: What it does, in paragraphs.
            options: As :class:`argparse.ArgumentParser` takes them.
        """
        super().__init__(
            prog=called(name),
            description=_filled(description or ""),
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
            **options,
        )

    def error(self, message: str) -> NoReturn:
        """Reject the arguments.

        Raises:
            UsageError: Always.
        """
        raise UsageError(f"{message}; see {self.prog} --help")

    def _print_message(self, message: str, _: Any = None) -> None:
        write_out(message)  # argparse would hide that it cannot be written


def called(name: str) -> str:
    """Return how a command is called in the set-up in which this process was started."""
    program = "ros2 fusion" if Path(sys.argv[0]).name == "ros2" else PROGRAM
    return f"{program} {name}".strip()


def _filled(text: str) -> str:
    """Return paragraphs, wrapped to the width of a terminal."""
    return "\n\n".join(textwrap.fill(each, WIDTH) for each in text.split("\n\n"))
