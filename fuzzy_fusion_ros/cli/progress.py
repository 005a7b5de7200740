"""Progress bars: on stderr, and only where a person looks at it."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
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


def _look() -> dict[str, Any]:
    return {
        "file": sys.stderr,
        "disable": not sys.stderr.isatty(),
        "leave": False,
        "dynamic_ncols": True,
        "unit_scale": True,
    }
