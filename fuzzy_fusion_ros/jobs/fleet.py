# SPDX-License-Identifier: Apache-2.0
"""Many tasks that do not depend on one another: here, in processes, or on a Dask cluster.

A task that fails with an error of the user's is no reason to lose the others: it has a
:class:`Failure` in place of its result.
"""

from __future__ import annotations

import functools
import multiprocessing
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import BrokenExecutor, Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

from fuzzy_fusion_ros.parameters.errors import FusionError

T = TypeVar("T")
R = TypeVar("R")

PATIENCE = 10.0
"""How long to wait for a scheduler to answer, seconds."""


class Failure(NamedTuple):
    """Why a task has no result.

    Attributes:
        reason: In words, one line.
    """

    reason: str


def outcomes(
    task: Callable[[T], R], items: Sequence[T], jobs: int = 1, scheduler: str | None = None
) -> Generator[R | Failure, None, None]:
    """Run a task for each of several items; yield the outcomes in their order.

    Closing the generator early drops the tasks that have not begun.

    Args:
        task: What to do; for another process it and the items must be picklable.
        items: What to do it with.
        jobs: How many tasks run at a time, each in a process; 1 is none but this one.
        scheduler: Address of a Dask scheduler, on whose workers the tasks run instead. A task whose
            worker dies runs again on another.

    Raises:
        FusionError: No scheduler answers.
    """
    guarded = functools.partial(_guarded, task)
    if scheduler is None and (jobs == 1 or len(items) == 1):
        yield from map(guarded, items)
        return
    with _cluster(scheduler) if scheduler else _processes(min(jobs, len(items))) as executor:
        futures: list[Future[R | Failure]] = [executor.submit(guarded, each) for each in items]
        for future in futures:
            try:
                yield future.result()
            except BrokenExecutor:
                yield Failure("a process ended before its task was done: out of memory?")


def _guarded(task: Callable[[T], R], item: T) -> R | Failure:
    try:
        return task(item)
    except FusionError as error:
        return Failure(" ".join(str(error).split()))


@contextmanager
def _processes(jobs: int) -> Iterator[Executor]:
    context = multiprocessing.get_context("spawn")  # a fork would copy locks of running threads
    with ProcessPoolExecutor(jobs, mp_context=context) as executor:
        try:
            yield executor
        finally:
            executor.shutdown(cancel_futures=True)


@contextmanager
def _cluster(address: str) -> Iterator[Executor]:
    import distributed  # takes time

    connect: Any = distributed.Client
    try:
        client = connect(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        raise FusionError(f"no Dask scheduler answers at {address!r}: {error}") from None
    with client, client.get_executor() as executor:
        yield executor
