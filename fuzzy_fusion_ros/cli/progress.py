# SPDX-License-Identifier: Apache-2.0
"""Progress bars on stderr, if that is a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sized
from contextlib import contextmanager
from typing import Any, TypeVar

from fuzzy_fusion_ros.jobs.progress import Progress
from fuzzy_fusion_ros.text.visible import visible

T = TypeVar("T")


class Bars(Progress):
    """Shows a progress bar for each thing that is under way."""

    def over(
        self,
        items: Iterable[T],
        text: str,
        total: int | None = None,
        unit: str = "",
        size: Callable[[T], int] = lambda _: 1,
    ) -> Iterable[T]:
        """Return the items, with a bar while they are iterated over."""
        length = len(items) if total is None and isinstance(items, Sized) else total
        with _bar(total=length, desc=visible(text), unit=unit) as bar:
            for item in items:
                yield item
                bar.update(size(item))

    @contextmanager
    def counted(self, text: str, unit: str = "") -> Iterator[Callable[[int, int], None]]:
        """Show a bar; yield what moves it."""
        with _bar(desc=visible(text), unit=unit) as bar:

            def advance(done: int, of: int) -> None:
                bar.total = of
                bar.update(done - bar.n)

            yield advance


def _bar(**options: Any) -> Any:
    from tqdm import tqdm  # costs start-up time

    return tqdm(
        file=sys.stderr,
        disable=not sys.stderr.isatty(),
        leave=False,
        dynamic_ncols=True,
        unit_scale=True,
        **options,
    )


BARS = Bars()
