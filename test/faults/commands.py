# SPDX-License-Identifier: Apache-2.0
"""A command's main, run in this process, its manners watched."""

from __future__ import annotations

import contextlib
import io
import signal
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import NamedTuple

LONGEST = 120.0
"""A command that takes more CPU time loops for ever, seconds."""


class Ended(NamedTuple):
    """How a command ended.

    Attributes:
        status: Its exit status.
        stdout: What it wrote to stdout.
        stderr: What it wrote to stderr.
    """

    status: int
    stdout: str
    stderr: str


def ended(main: Callable[[Sequence[str]], int], arguments: Sequence[str]) -> Ended:
    """Run a command; what it raises, other than an exit, passes through.

    Raises:
        TimeoutError: It hangs.
    """
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), no_hang():
        try:
            status = main(arguments)
        except SystemExit as end:
            status = end.code if isinstance(end.code, int) else 1
    return Ended(status, out.getvalue(), err.getvalue())


def mannerly(main: Callable[[Sequence[str]], int], arguments: Sequence[str]) -> Ended:
    """Run a command on input that may be unusable; return how it ended.

    Raises:
        AssertionError: It neither did its work, nor refused with one line and status 2, nor did
            so for some of several bags, each in a row, with status 1.
        TimeoutError: It hangs.
    """
    end = ended(main, arguments)
    assert end.status in (0, 2) or (end.status == 1 and "failed: " in end.stdout), end
    if end.status == 2:
        assert end.stderr.count("\n") == 1, end
        assert end.stderr.endswith("\n"), end
        assert end.stdout == "", end
    assert "Traceback" not in end.stderr, end
    assert all(line.isprintable() for line in (end.stdout + end.stderr).split("\n")), end
    return end


@contextlib.contextmanager
def no_hang(seconds: float = LONGEST) -> Iterator[None]:
    """Interrupt what computes too long, however busy the machine is; main thread only.

    Raises:
        TimeoutError: It does.
    """

    def expire(number: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"still running after {seconds} s of CPU time")

    before = signal.signal(signal.SIGPROF, expire)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
