# SPDX-License-Identifier: Apache-2.0
"""Waiting for what other processes do."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sized
from typing import Any

LOOK = 0.005
"""Seconds between two looks."""


def wait_until(predicate: Callable[[], Any], what: str, timeout: float = 60.0) -> None:
    """Look until something is so.

    Raises:
        TimeoutError: It is still not so.
    """
    deadline = time.monotonic() + timeout
    while not predicate():
        if time.monotonic() > deadline:
            raise TimeoutError(f"{what} is not so after {timeout:g} s")
        time.sleep(LOOK)


def after(seconds: float) -> Callable[[], bool]:
    """Return a predicate that is so from a moment on: the moment of a fault is an input."""
    moment = time.monotonic() + seconds
    return lambda: time.monotonic() >= moment


def at_least(number: int, things: Sized) -> Callable[[], bool]:
    """Return a predicate that is so once there are so many things."""
    return lambda: len(things) >= number


def said_again(count: Callable[[str], int], text: str) -> Callable[[], bool]:
    """Return a predicate that is so once a text has been said once more than by now."""
    before = count(text)
    return lambda: count(text) > before


def as_arguments(parameters: Mapping[str, object]) -> list[str]:
    """Return parameters as a command line gives them."""
    given = [
        f"{name}:={str(value).lower() if isinstance(value, bool) else value}"
        for name, value in parameters.items()
    ]
    return ["--ros-args", *(word for each in given for word in ("-p", each))]
