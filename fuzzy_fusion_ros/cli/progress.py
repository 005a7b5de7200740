# SPDX-License-Identifier: Apache-2.0
"""Progress bars on stderr, if that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

from fuzzy_fusion_ros.jobs.progress import Progress
from fuzzy_fusion_ros.text.visible import visible

T = TypeVar("T")


class Bars(Progress):
    """Shows a progress bar for each thing that is under way."""

    def over(
        self, items: Iterable[T], text: str, total: int | None = None, unit: str = ""
    ) -> Iterable[T]:
        """Return the items, with a bar while they are iterated over."""
        shown: Iterable[T] = _bar(items, total=total, desc=visible(text), unit=unit)
        return shown

    @contextmanager
    def counted(self, text: str, unit: str = "") -> Iterator[Callable[[int, int], None]]:
        """Show a bar; yield what moves it."""
        with _bar(None, desc=visible(text), unit=unit) as bar:

            def advance(done: int, of: int) -> None:
                bar.total = of
                bar.update(done - bar.n)

            yield advance


def _bar(items: Iterable[Any] | None, **options: Any) -> Any:
    from tqdm import tqdm  # costs start-up time

    return tqdm(
        items,
        file=sys.stderr,
        disable=not sys.stderr.isatty(),
        leave=False,
        dynamic_ncols=True,
        unit_scale=True,
        **options,
    )


BARS = Bars()
