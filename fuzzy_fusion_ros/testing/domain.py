# SPDX-License-Identifier: Apache-2.0
"""Claims a DDS domain that no other test on this machine uses, for processes to join."""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path

DOMAINS = range(1, 102)
"""Domains whose ports lie below Linux's ephemeral range; 0 is the default one, so not ours."""


@contextlib.contextmanager
def claimed_domain() -> Iterator[int]:
    """Context manager: reserve a domain against other processes and threads.

    The claim is a file lock, so it ends with the process, however that exits.

    Raises:
        RuntimeError: Every domain is claimed.
    """
    folder = Path(tempfile.gettempdir(), "fuzzy_fusion_ros-domains")
    folder.mkdir(exist_ok=True)
    with contextlib.suppress(PermissionError):
        folder.chmod(0o1777)
    first = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[first:], *DOMAINS[:first]):
        lock = os.open(folder / str(domain), os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            continue
        try:
            yield domain
        finally:
            os.close(lock)
        return
    raise RuntimeError(f"DDS domains {DOMAINS[0]} to {DOMAINS[-1]} are all claimed: see {folder}")


def isolation(domain: int) -> dict[str, str]:
    """Return the environment variables that keep a process in a domain of this machine."""
    return {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_DOMAIN_ID": str(domain)}


@contextlib.contextmanager
def environment(values: Mapping[str, str]) -> Iterator[None]:
    """Context manager: environment variables of this process, put back in the end."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
