"""Files that a job writes: whether it can, and what to say if it cannot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from fuzzy_fusion_ros.parameters.errors import FusionError


class OutputError(FusionError):
    """A file or directory cannot be written."""


@contextmanager
def writing(path: str | Path) -> Iterator[None]:
    """Context manager: report any failure to write as an error of the user's.

    Raises:
        OutputError: The path cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise OutputError(f"{str(path)!r} cannot be written: {error.strerror or error}") from None


def require_writable(*paths: str | Path | None) -> None:
    """Check that files can be written, before work that takes long; leave nothing behind.

    Args:
        paths: The files; ``None`` is none, and ``-`` is stdout.

    Raises:
        OutputError: A file cannot be written.
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
