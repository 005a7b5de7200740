"""Progress bars: on stderr, and only where a person looks at it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from tqdm import tqdm

T = TypeVar("T")


def progress(
    items: Iterable[T], text: str, total: int | None = None, unit: str = ""
) -> Iterator[T]:
    """Return the items, and show how far it is while they are taken.

    Args:
        items: What is gone through.
        text: What is done with them.
        total: How many there are, where they cannot tell themselves.
        unit: What they are, with a space before it.
    """
    return iter(tqdm(items, total=total, desc=text, unit=unit, **_look()))


def bar(text: str, total: int | None = None, unit: str = "") -> tqdm[Any]:
    """Return a bar to move by hand; a context manager."""
    return tqdm(total=total, desc=text, unit=unit, **_look())


@contextmanager
def counted(text: str, unit: str = "") -> Iterator[Callable[[int, int], None]]:
    """Show a bar to move by telling how much is done, and of how much.

    Args:
        text: What is done.
        unit: What is counted, with a space before it.
    """
    with bar(text, unit=unit) as shown:

        def advance(done: int, of: int) -> None:
            shown.total = of
            shown.update(done - shown.n)

        yield advance


def _look() -> dict[str, Any]:
    return {
        "file": sys.stderr,
        "disable": not sys.stderr.isatty(),
        "leave": False,
        "dynamic_ncols": True,
        "unit_scale": True,
    }
