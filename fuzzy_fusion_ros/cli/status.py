# SPDX-License-Identifier: Apache-2.0
"""Exit statuses, and the one place where an error becomes one."""

from __future__ import annotations

import functools
import os
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from types import FrameType

from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.stdout import discard, write_out
from fuzzy_fusion_ros.text.visible import visible

DONE = 0
FAILED = 1
"""Done, and a check failed: a claim, a score regression, a replay that differs."""
UNUSABLE = 2
"""The input or the arguments cannot be used."""

GRACE = 5.0
"""Seconds from a signal to the end of the process, whatever it does."""

LONGEST = 2000
"""Characters of a message: a name can have thousands."""

_ENDED = {signal.SIGINT: "interrupted", signal.SIGTERM: "terminated"}

Main = Callable[[Sequence[str] | None], int]


def command(name: str) -> Callable[[Main], Callable[..., int]]:
    """Make a command of a function: its errors become a line on stderr and an exit status.

    Every :class:`FusionError` gives status 2, and so does a library that is not installed. An
    interrupt gives 128 and the signal's number, and so does a reader of stdout that has gone away,
    as with any Unix tool. What an interrupt has to say of the work so far is said. No traceback.

    Args:
        name: The command's name, said before each error.
    """

    def decorate(main: Main) -> Callable[..., int]:
        @functools.wraps(main)
        def run(arguments: Sequence[str] | None = None) -> int:
            _reserve_streams()
            termination = _Termination()
            try:
                with termination:
                    return main(arguments)
            except FusionError as error:
                say(name, error)
                return UNUSABLE
            except ModuleNotFoundError as error:
                say(name, _missing(error))
                return UNUSABLE
            except MemoryError:
                say(name, "out of memory: the input needs more than is available")
                return UNUSABLE
            except BrokenPipeError:
                return 128 + signal.SIGPIPE
            except KeyboardInterrupt as error:
                say(name, ": ".join([_ENDED[termination.number], *map(str, error.args)]))
                return 128 + termination.number

        return run

    return decorate


def say(name: str, message: object) -> None:
    """Print a message of a command on stderr, on one line of at most ``LONGEST`` characters."""
    line = visible(f"{name}: {' '.join(str(message).split())}")
    if len(line) > LONGEST:
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    _tell(line)


def show(text: str, *, on_stderr: bool = False) -> None:
    """Print a result of a command: on stdout, or on stderr where that is taken.

    What a terminal would obey stands as an escape.

    Raises:
        UsageError: Stdout is closed or full.
    """
    lines = "\n".join(map(visible, text.split("\n")))
    if on_stderr:
        _tell(lines)
    else:
        write_out(f"{lines}\n")


def _tell(text: str) -> None:
    try:
        print(text, file=sys.stderr, flush=True)
    except OSError:  # there is nowhere left to say so
        discard(sys.stderr)


def _reserve_streams() -> None:
    """Open what the caller has closed of stdin, stdout and stderr.

    No other file takes their places. What is written to stdout fails then; what is said on stderr
    goes nowhere.
    """
    for number, mode in enumerate((os.O_RDONLY, os.O_RDONLY, os.O_WRONLY)):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, mode)  # takes the smallest number that is free, this one
    if sys.stdout is None:
        sys.stdout = os.fdopen(os.open(os.devnull, os.O_RDONLY), "w", encoding="utf-8")
    if sys.stderr is None:
        sys.stderr = os.fdopen(os.open(os.devnull, os.O_WRONLY), "w", encoding="utf-8")


def _missing(error: ModuleNotFoundError) -> str:
    """Say how to install what is not there.

    Raises:
        ModuleNotFoundError: It is a part of this package.
    """
    library = str(error.name).partition(".")[0]
    if library == __package__.partition(".")[0]:
        raise error
    if library == "rclpy" or library.endswith(("_msgs", "_srvs")):
        return (
            f"needs ROS 2, but {library} was not found: source ROS 2, for example "
            "/opt/ros/jazzy/setup.bash"
        )
    return (
        f"{library} is not installed: in a workspace, run src/fuzzy_fusion_ros/install.sh; "
        f"in a virtual environment, pip install {library}"
    )


class _Termination:
    """While it lasts, SIGINT and SIGTERM unwind as ``KeyboardInterrupt``, so that files are closed.

    Unwinding may be impossible: in compiled code that runs for minutes, and where a library
    swallows the exception. After ``GRACE`` seconds, or at the next signal, the process ends anyway.

    Attributes:
        number: The signal that has come, SIGINT before.
    """

    def __init__(self) -> None:
        self.number = signal.SIGINT

    def __enter__(self) -> None:
        self._main = threading.current_thread() is threading.main_thread()
        if self._main:
            found = {number: signal.getsignal(number) for number in _ENDED}
            self._before = {each: found[each] for each in found if found[each] != signal.SIG_IGN}
            for number in self._before:
                signal.signal(number, self._unwind)
            self._done = threading.Event()
            reading, self._written = os.pipe()
            if hasattr(os, "set_blocking"):  # Windows gets it with Python 3.12, and needs it not
                os.set_blocking(self._written, False)
            self._wakeup = signal.set_wakeup_fd(self._written, warn_on_full_buffer=False)
            threading.Thread(target=self._watch, args=(reading,), daemon=True).start()

    def __exit__(self, *_: object) -> None:
        if self._main:
            self._done.set()
            signal.set_wakeup_fd(self._wakeup)
            os.close(self._written)
            for number, handler in self._before.items():
                signal.signal(number, handler)

    def _unwind(self, number: int, _: FrameType | None) -> None:
        for each in self._before:
            signal.signal(each, signal.SIG_DFL)
        self.number = signal.Signals(number)
        raise KeyboardInterrupt

    def _watch(self, reading: int) -> None:
        """Wait for the first signal, which the system reports even while no Python code runs."""
        with open(reading, "rb", buffering=0) as signals:
            while number := signals.read(1):
                if number[0] in self._before and not self._done.wait(GRACE):
                    os._exit(128 + number[0])
