# SPDX-License-Identifier: Apache-2.0
"""Commands that take several bags: their options, and how failures of single bags are handled."""

from __future__ import annotations

import argparse
import gc
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TypeVar

from fuzzy_fusion_ros.cli.progress import BARS
from fuzzy_fusion_ros.jobs.fleet import Failure, Interrupted, outcomes
from fuzzy_fusion_ros.jobs.progress import SILENT, Progress
from fuzzy_fusion_ros.parameters.errors import FusionError

T = TypeVar("T")
R = TypeVar("R")

MOST_JOBS = 1024

MOST_NAMED = 5
"""Bags that are named one by one."""


def add_bags(parser: argparse.ArgumentParser) -> None:
    """Add the bags, ``--jobs`` and ``--scheduler``."""
    add_local_bags(parser)
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="process the bags on the cluster of this Dask scheduler, for example "
        "tcp://host:8786; its workers must see the bags and all files named here at the same "
        "absolute paths",
    )


def add_local_bags(
    parser: argparse.ArgumentParser,
    jobs: str = "process this many bags at a time, each in its own process {1}",
) -> None:
    """Add the bags and ``--jobs`` of a command that does not work on a cluster.

    Args:
        parser: Where to.
        jobs: What ``--jobs`` does, in words.
    """
    parser.set_defaults(scheduler=None)
    parser.add_argument(
        "bag", metavar="BAG", nargs="+", help="rosbag2 directory or .mcap file; one or several"
    )
    parser.add_argument(
        "--jobs",
        metavar="N",
        type=_jobs,
        default=1,
        help=jobs,
    )


def progress_of(arguments: argparse.Namespace) -> Progress:
    """Return what shows the progress within a bag: nothing where another process works on it."""
    return SILENT if arguments.scheduler or arguments.jobs > 1 else BARS


def absolute(path: str | None, arguments: argparse.Namespace) -> str | None:
    """Return a path as a task is to be given it: absolute where another machine may read it."""
    return os.path.abspath(path) if path is not None and arguments.scheduler else path


def bags_of(arguments: argparse.Namespace) -> list[str]:
    """Return the bags, each once however often it is named, as tasks are to be given them."""
    return list(dict.fromkeys(absolute(each, arguments) or each for each in arguments.bag))


def run(
    task: Callable[[T], R], items: Mapping[str, T], arguments: argparse.Namespace
) -> list[R | Failure]:
    """Run a task for each bag.

    Args:
        task: The task.
        items: What it takes, by the name of what is complete once it is done.
        arguments: What was given.

    Raises:
        FusionError: There is one bag only, and it cannot be used; or no scheduler answers.
        KeyboardInterrupt: It says which are done, and what the others say of their work so far.
    """
    gc.freeze()  # what is imported stays: not to be searched for garbage after every few bags
    ran: Iterator[R | Failure | Interrupted] = outcomes(
        task, list(items.values()), arguments.jobs, arguments.scheduler
    )
    if len(items) > 1 and progress_of(arguments) is SILENT:
        ran = iter(BARS.over(ran, "bags", len(items), " bags"))
    found: list[R | Failure] = []
    unfinished: list[Interrupted] = []
    complete: list[str] = []
    try:
        for name, each in zip(items, ran, strict=True):
            if isinstance(each, Interrupted):
                unfinished.append(each)
                continue
            found.append(each)
            complete += [] if isinstance(each, Failure) else [name]
    except KeyboardInterrupt:
        unfinished.append(Interrupted(""))
    if unfinished:
        raise KeyboardInterrupt(*_so_far(complete, unfinished, len(items)))
    if len(found) == 1 and isinstance(found[0], Failure):
        raise FusionError(found[0].reason)
    return found


def _so_far(complete: Sequence[str], unfinished: Iterable[Interrupted], of: int) -> list[str]:
    """Return what is complete and what is not, as a text if there is anything to say."""
    parts = [each.so_far for each in unfinished if each.so_far]
    if of > 1:
        more = [f"{len(complete) - MOST_NAMED} more"] if len(complete) > MOST_NAMED else []
        names = ", ".join([*complete[:MOST_NAMED], *more])
        named = f" ({names})" if complete else ""
        parts.insert(0, f"{len(complete)} of {of} bags are done{named}")
    return ["; ".join(parts)] if parts else []


def failed_row(bag: str, failure: Failure, columns: int) -> tuple[str, ...]:
    """Return the row of a bag that failed, in a table with that many columns."""
    return (bag, *[""] * (columns - 2), f"failed: {failure.reason}")


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= MOST_JOBS:
        raise argparse.ArgumentTypeError(f"got {text!r}, expected an integer from 1 to {MOST_JOBS}")
    return int(text)
