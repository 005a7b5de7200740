# SPDX-License-Identifier: Apache-2.0
"""Files that a job writes: whether it can, and what to say if it cannot."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from fuzzy_fusion_ros.parameters.writing import OutputError, writing

_Name = tuple[int, int] | tuple[str]
"""Device and number of a file that exists, or the path of one that does not."""


def require_writable(*outputs: str | Path | None, inputs: Iterable[object] = ()) -> None:
    """Check that files can be written, before work that takes long; leave nothing behind.

    Args:
        outputs: The files; ``None`` is none, and ``-`` is stdout.
        inputs: What must not be written over: files, directories with the files in them, and
            anything else, which is not a file.

    Raises:
        OutputError: A file cannot be written, is given twice, or is an input, by whatever name.
    """
    taken = {
        name: f"is read from {str(path)!r}"
        for path in inputs
        if isinstance(path, (str, Path))
        for name in _files_of(path)
    }
    for output in outputs:
        if output is None or output == "-":
            continue
        with writing(os.path.realpath(output)) as path:
            was_there = path.exists()
            if not was_there or path.is_file() or path.is_dir():  # no device, no pipe
                path.open("ab").close()
                name = _name_of(path)
                if not was_there:
                    path.unlink()
                    name = (str(path),)
                if name in taken:
                    raise OutputError(f"{str(output)!r} {taken[name]}: choose another file")
                taken[name] = f"is already written as {str(output)!r}"


def _files_of(path: str | Path) -> Iterator[_Name]:
    """Yield what names the file at a path, or each file in the directory there."""
    try:
        for each in Path(path).iterdir() if os.path.isdir(path) else [Path(path)]:
            yield _name_of(each)
    except (OSError, ValueError):
        return  # whoever reads it says why it cannot be read


def _name_of(path: Path) -> _Name:
    """Return what names a file whatever links lead to it."""
    status = path.stat()
    return status.st_dev, status.st_ino


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
