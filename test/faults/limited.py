# SPDX-License-Identifier: Apache-2.0
"""Runs commands in processes that may use a gigabyte of memory and some seconds.

    python limited.py CASES

CASES is a JSON file: by the name of each case, a command and its arguments. What became of each
goes to stdout as JSON.
"""

from __future__ import annotations

import json
import os
import resource
import sys
import tempfile
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import IO

MEMORY = 1 << 30
"""Bytes of address space, that of the libraries included."""

SECONDS = 60
"""Of CPU time; the cases take a tenth of it at most on a machine at rest."""


def main() -> None:
    """Run the cases one by one, each in a fork that has the commands imported."""
    from fuzzy_fusion_ros.cli import replay, score, tune
    from fuzzy_fusion_ros.jobs import replay as _replay
    from fuzzy_fusion_ros.jobs import score as _score

    del _replay, _score
    commands = {"replay": replay.main, "score": score.main, "tune": tune.main}
    ended = {}
    for name, (command, *arguments) in json.loads(Path(sys.argv[1]).read_text()).items():
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            child = os.fork()
            if child == 0:
                _limit(out, err)
                os._exit(_status(commands[command], arguments))
            _, status, used = os.wait4(child, 0)
            texts = []
            for stream in (out, err):
                stream.seek(0)
                texts.append(stream.read().decode(errors="backslashreplace"))
            ended[name] = (os.waitstatus_to_exitcode(status), *texts, used.ru_utime + used.ru_stime)
    print(json.dumps(ended))


def _limit(out: IO[bytes], err: IO[bytes]) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
    os.dup2(out.fileno(), 1)
    os.dup2(err.fileno(), 2)


def _status(command: Callable[[list[str]], int], arguments: list[str]) -> int:
    """Return the exit status of a command; a traceback gives 1, as in Python itself."""
    try:
        status = command(arguments)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else 1
    except BaseException:  # a fork ends here: above are the cases of its parent
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return int(status)


if __name__ == "__main__":
    main()
