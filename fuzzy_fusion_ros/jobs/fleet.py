# SPDX-License-Identifier: Apache-2.0
"""Many tasks that do not depend on one another: here, in processes, or on a Dask cluster.

A task that fails with an error of the user's is no reason to lose the others: it has a
:class:`Failure` in place of its result. SIGINT, or another end of this process, ends those in
processes, too.
"""

from __future__ import annotations

import functools
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
)
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from typing import Any, NamedTuple, TypeVar

from fuzzy_fusion_ros.parameters.errors import FusionError

T = TypeVar("T")
R = TypeVar("R")

STOP = getattr(signal, "SIGUSR1", signal.SIGINT)
"""Signal that interrupts a task in a worker process. A terminal or ``timeout`` sends SIGINT or
SIGTERM to every process of a group; only the parent decides what those mean."""

GRACE = 5.0
"""Seconds from SIGTERM to the end of a process: time to close files, not to wait for others."""

POLL = 0.1
"""Seconds between looks at a parent that ends."""

PATIENCE = 10.0
"""How long to wait for a scheduler to answer, seconds."""


class Failure(NamedTuple):
    """Why a task has no result.

    Attributes:
        reason: In words, one line.
    """

    reason: str


class Interrupted(NamedTuple):
    """Why a task has no result that was interrupted, or had not begun by then.

    Attributes:
        so_far: What it says of its work so far, one line; ``""`` if nothing.
    """

    so_far: str


def outcomes(
    task: Callable[[T], R], items: Sequence[T], jobs: int = 1, scheduler: str | None = None
) -> Generator[R | Failure | Interrupted, None, None]:
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
        KeyboardInterrupt: It came while tasks ran in processes, once the outcomes of these have
            been yielded, or on a cluster, which drops them.
    """
    guarded = functools.partial(_guarded, task)
    if scheduler is None and (jobs == 1 or len(items) == 1):
        yield from _in_turn(guarded, items)
    elif scheduler is None:
        yield from _in_processes(guarded, items, min(jobs, len(items)))
    else:
        with _cluster(scheduler) as executor:
            yield from map(_outcome, [executor.submit(guarded, each) for each in items])


def _guarded(task: Callable[[T], R], item: T) -> R | Failure | Interrupted:
    try:
        return task(item)
    except FusionError as error:
        return Failure(" ".join(str(error).split()))
    except KeyboardInterrupt as error:
        return Interrupted(": ".join(map(str, error.args)))


def _in_turn(
    guarded: Callable[[T], R | Failure | Interrupted], items: Sequence[T]
) -> Iterator[R | Failure | Interrupted]:
    outcome: R | Failure | Interrupted = Interrupted("")
    for at, item in enumerate(items):
        is_over = at > 0 and isinstance(outcome, Interrupted)
        outcome = Interrupted("") if is_over else guarded(item)
        yield outcome


def _in_processes(
    guarded: Callable[[T], R | Failure | Interrupted], items: Sequence[T], jobs: int
) -> Iterator[R | Failure | Interrupted]:
    context = multiprocessing.get_context("spawn")  # a fork would copy locks of running threads
    reading, writing = context.Pipe(duplex=False)
    with (
        reading,
        writing,
        ProcessPoolExecutor(jobs, context, initializer=_serve, initargs=(reading,)) as executor,
    ):
        one: Callable[[T], R | Failure | Interrupted] = functools.partial(_interruptible, guarded)
        futures = [executor.submit(one, each) for each in items]
        done = 0
        try:
            for future in futures:
                yield _outcome(future)
                done += 1
        except KeyboardInterrupt:
            writing.close()
            executor.shutdown(cancel_futures=True)
            yield from map(_outcome, futures[done:])
            raise
        finally:
            executor.shutdown(cancel_futures=True)


def _outcome(
    future: Future[R | Failure | Interrupted],
) -> R | Failure | Interrupted:
    try:
        return future.result()
    except BrokenExecutor:
        return Failure("a process ended before its task was done: out of memory?")
    except CancelledError:
        return Interrupted("")


def _serve(stop: Connection) -> None:
    """Prepare a process for tasks.

    Args:
        stop: At its end, which the end of the parent is, too, the task is interrupted.
    """
    for each in (signal.SIGINT, STOP):
        signal.signal(each, signal.SIG_IGN)
    threading.Thread(target=_watch, args=(stop,), daemon=True).start()


def _watch(stop: Connection) -> None:
    with suppress(EOFError):
        stop.recv()
    parent = multiprocessing.parent_process()
    while parent is not None and parent.is_alive():
        os.kill(os.getpid(), STOP)  # the next task as well, which may be under way already
        parent.join(POLL)
    os._exit(1)


def _interruptible(
    guarded: Callable[[T], R | Failure | Interrupted], item: T
) -> R | Failure | Interrupted:
    """Run a task in a process of ours, which the first ``STOP`` or SIGTERM interrupts."""
    try:
        signal.signal(STOP, _interrupt)
        signal.signal(signal.SIGTERM, _terminate)
        outcome = guarded(item)
        signal.signal(STOP, _ignore)
    except BaseException:  # what an interrupt becomes at a task's edge, or in a lock's wait
        if signal.getsignal(STOP) is _interrupt:
            raise
        outcome = Interrupted("")
    finally:
        signal.signal(STOP, _ignore)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
    return outcome


def _interrupt(*_: object) -> None:
    if signal.getsignal(STOP) is _interrupt:  # a second one would tear what unwinds
        signal.signal(STOP, _ignore)
        raise KeyboardInterrupt


def _ignore(*_: object) -> None:
    """Unlike ``SIG_IGN``, also of a signal that has come already."""


def _terminate(*_: object) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    ending = threading.Timer(GRACE, os._exit, (1,))
    ending.daemon = True
    ending.start()
    _interrupt()


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
