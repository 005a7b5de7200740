"""Files that a job writes: whether it can, and what to say if it cannot."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
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


def require_no_input(
    paths: Iterable[str | Path | None], inputs: Iterable[str | Path | None]
) -> None:
    """Check that no file to write is one that is read, nor within a directory that is read.

    Args:
        paths: The files to write; ``None`` is none, and ``-`` is stdout.
        inputs: What is read; ``None`` is none.

    Raises:
        OutputError: A file is an input.
    """
    read = {Path(each).resolve() for each in inputs if each is not None}
    for path in paths:
        if path is None or path == "-":
            continue
        target = Path(path).resolve()
        if not read.isdisjoint([target, *target.parents]):
            raise OutputError(f"{str(path)!r} is an input: name another file to write to")


def one_for_each(path: str | Path, names: Sequence[str]) -> list[Path]:
    """Return the files for several recordings: one as given, more with the bags' names added.

    Bags of the same name in different directories are numbered, too.
    """
    given = Path(path)
    if len(names) == 1:
        return [given]
    stems = [Path(each).stem for each in names]
    if len(set(stems)) < len(stems):
        stems = [f"{number}_{stem}" for number, stem in enumerate(stems, 1)]
    return [given.with_stem(f"{given.stem}_{stem}") for stem in stems]
