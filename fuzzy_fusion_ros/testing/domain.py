"""A DDS domain that no other test on this machine uses."""

from __future__ import annotations

import contextlib
import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

DOMAINS = range(1, 102)
"""Those whose ports lie below the ones that Linux hands out; 0 is everybody's."""


@contextlib.contextmanager
def claimed_domain() -> Iterator[int]:
    """Claim a domain for as long as the context lasts, against other processes and threads.

    The claim is a lock on a file, so it ends with the process whatever happens.

    Raises:
        RuntimeError: All are claimed.
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
    raise RuntimeError(f"all domains from {DOMAINS[0]} to {DOMAINS[-1]} are claimed, see {folder}")
