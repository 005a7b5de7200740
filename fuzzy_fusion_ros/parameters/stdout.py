# SPDX-License-Identifier: Apache-2.0
"""Writes results to stdout; what cannot be written is an error, not lost."""

from __future__ import annotations

import os
import sys
from typing import TextIO

from fuzzy_fusion_ros.parameters.errors import UsageError


def write_out(text: str) -> None:
    """Write a text to stdout at once; characters that its encoding lacks become escapes.

    Raises:
        UsageError: Stdout is closed or full.
        BrokenPipeError: Who reads it has gone away.
    """
    encoding = sys.stdout.encoding or "utf-8"
    try:
        sys.stdout.write(text.encode(encoding, "backslashreplace").decode(encoding))
        sys.stdout.flush()
    except OSError as error:
        discard(sys.stdout)
        if isinstance(error, BrokenPipeError):
            raise
        raise UsageError(f"stdout cannot be written: {error.strerror}") from None


def discard(stream: TextIO) -> None:
    """Send what is left in a stream, and what follows, nowhere: Python flushes it at its end."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
