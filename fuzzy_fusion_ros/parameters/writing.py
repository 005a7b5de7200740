# SPDX-License-Identifier: Apache-2.0
"""Writes files of results: their directories are made, and a failure is the user's to read."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fuzzy_fusion_ros.parameters.errors import FusionError


class OutputError(FusionError):
    """A file or directory cannot be written."""


@contextmanager
def writing(path: str | Path) -> Iterator[Path]:
    """Context manager: make the directory of a file, and report any failure to write.

    Yields:
        The path.

    Raises:
        OutputError: The path cannot be written.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield target
    except OSError as error:
        raise OutputError(f"{str(path)!r} cannot be written: {error.strerror or error}") from None
