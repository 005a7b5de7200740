# SPDX-License-Identifier: Apache-2.0
"""What ros2cli loads for ``ros2 fusion``."""

from __future__ import annotations

import argparse

from fuzzy_fusion_ros.cli.program import add_verbs, run


class FusionCommand:
    """Fuse a fast and an accurate sensor; replay, score and tune on recordings.

    An extension of ros2cli by its methods alone, so that it needs no import of it.
    """

    def add_arguments(self, parser: argparse.ArgumentParser, cli_name: str) -> None:
        """Add the verb and what follows it."""
        self._parser = parser
        add_verbs(parser)

    def main(self, *, parser: argparse.ArgumentParser, args: argparse.Namespace) -> int:
        """Run the verb; return the exit status.

        Args:
            parser: Of ros2 as a whole.
            args: What it has parsed.
        """
        return run(self._parser, args)
