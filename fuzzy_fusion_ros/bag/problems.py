# SPDX-License-Identifier: Apache-2.0
"""Problems of a bag, as lines for the user."""

from __future__ import annotations

_LIMIT = 20


class Problems:
    """A list of problems, each listed once and not too many of them.

    Attributes:
        lines: One line per problem, in the order in which they were met.
    """

    def __init__(self) -> None:
        self.lines: list[str] = []

    def note(self, source: str, problem: str) -> None:
        """Add a problem of a file or another source, unless it is listed already."""
        line = f"{source}: {problem}"
        if line in self.lines:
            return
        if len(self.lines) < _LIMIT:
            self.lines.append(line)
        elif len(self.lines) == _LIMIT:
            self.lines.append("further problems are not listed")
