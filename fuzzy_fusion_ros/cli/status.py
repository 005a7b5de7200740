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
from fuzzy_fusion_ros.text.visible import visible

DONE = 0
FAILED = 1
"""Done, and a check failed: a claim, a score regression, a replay that differs."""
UNUSABLE = 2
"""The input or the arguments cannot be used."""

LONGEST = 2000
"""Characters of a message: a name can have thousands."""

Main = Callable[[Sequence[str] | None], int]


def command(name: str) -> Callable[[Main], Callable[..., int]]:
    """Make a command of a function: its errors become a line on stderr and an exit status.

    Every :class:`FusionError` gives status 2, and so does a library that is not installed. An
    interrupt gives 128 and the signal's number, and so does a reader of stdout that has gone away,
    as with any Unix tool. No traceback.

    Args:
        name: The command's name, said before each error.
    """

    def decorate(main: Main) -> Callable[..., int]:
        @functools.wraps(main)
        def run(arguments: Sequence[str] | None = None) -> int:
            try:
                with _Termination():
                    status = main(arguments)
                    sys.stdout.flush()
            except FusionError as error:
                say(name, error)
                return UNUSABLE
            except ModuleNotFoundError as error:
                say(name, _missing(error))
                return UNUSABLE
            except MemoryError:
                say(name, "out of memory: the input needs more than there is")
                return UNUSABLE
            except BrokenPipeError:
                os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
                return 128 + signal.SIGPIPE
            except KeyboardInterrupt:
                say(name, "interrupted")
                return 128 + signal.SIGINT
            return status

        return run

    return decorate


def say(name: str, message: object) -> None:
    """Print a message of a command on stderr, on one line of at most ``LONGEST`` characters."""
    line = visible(f"{name}: {' '.join(str(message).split())}")
    if len(line) > LONGEST:
        line = f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 :]}"
    print(line, file=sys.stderr, flush=True)


def show(text: str, *, on_stderr: bool = False) -> None:
    """Print a result of a command: on stdout, or on stderr where that is taken.

    What the terminal cannot write, or would obey, stands as an escape.
    """
    stream = sys.stderr if on_stderr else sys.stdout
    encoding = stream.encoding or "utf-8"
    lines = "\n".join(map(visible, text.split("\n")))
    print(lines.encode(encoding, "backslashreplace").decode(encoding), file=stream)


def _missing(error: ModuleNotFoundError) -> str:
    """Say how to install what is not there.

    Raises:
        ModuleNotFoundError: It is a part of this package.
    """
    library = str(error.name).partition(".")[0]
    if library == __package__.partition(".")[0]:
        raise error
    if library == "rclpy" or library.endswith(("_msgs", "_srvs")):
        return f"{library} is not found: source ROS 2, for example /opt/ros/jazzy/setup.bash"
    return (
        f"{library} is not installed: in a workspace, src/fuzzy_fusion_ros/install.sh brings it; "
        f"in a virtual environment, pip install {library}"
    )


class _Termination:
    """While it lasts, SIGTERM unwinds as an exit does, so that files are closed."""

    def __enter__(self) -> None:
        self._main = threading.current_thread() is threading.main_thread()
        if self._main:
            self._before = signal.signal(signal.SIGTERM, _exit)

    def __exit__(self, *_: object) -> None:
        if self._main:
            signal.signal(signal.SIGTERM, self._before)


def _exit(number: int, _: FrameType | None) -> None:
    raise SystemExit(128 + number)
