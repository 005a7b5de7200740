"""The parser of every command line, of nodes and offline programs alike."""

from __future__ import annotations

import argparse
import textwrap
from typing import Any, NoReturn

from fuzzy_fusion_ros.parameters.errors import UsageError
from fuzzy_fusion_ros.text.table import WIDTH


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in a single line."""

    def __init__(self, name: str, description: str | None, **options: Any) -> None:
        """Create a parser.

        Args:
            name: The command.
            description: What it does, in paragraphs.
            options: As :class:`argparse.ArgumentParser` takes them.
        """
        super().__init__(
            prog=name,
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


def _filled(text: str) -> str:
    """Return paragraphs, wrapped to the width of a terminal."""
    return "\n\n".join(textwrap.fill(each, WIDTH) for each in text.split("\n\n"))
