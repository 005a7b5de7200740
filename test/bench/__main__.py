# SPDX-License-Identifier: Apache-2.0
"""Runs the benchmarks and prints their table: python -m bench [--only NAME ...] [--compiled]."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable

from bench import (
    bags,
    estimator,
    fleet,
    growth,
    lockstep,
    machine,
    memory,
    programs,
    replaying,
    startup,
    transport,
)
from bench.effort import FULL, TINY, Effort
from bench.table import Row, line, markdown

BENCHMARKS: dict[str, Callable[[Effort], list[Row]]] = {
    "estimator": estimator.rows,
    "node": transport.rows,
    "lockstep": lockstep.rows,
    "start-up": startup.rows,
    "replay": replaying.rows,
    "bags": bags.rows,
    "memory": memory.rows,
    "fleet": fleet.rows,
    "growth": growth.rows,
    "programs": programs.rows,
}


def main() -> None:
    """Run what is asked for."""
    given = _parser().parse_args()
    if given.compiled:
        with tempfile.TemporaryDirectory() as folder:
            sys.exit(_compiled(folder))
    effort = TINY if given.tiny else FULL._replace(repetitions=given.repetitions)
    if given.messages:
        effort = effort._replace(messages=given.messages)
    head = machine.described()
    rows = []
    for name in given.only or BENCHMARKS:
        for row in BENCHMARKS[name](effort):
            print(line(row), file=sys.stderr, flush=True)
            rows.append(row)
    print(f"{head}; {effort.repetitions} interleaved repetitions\n\n{markdown(rows)}")


def _compiled(folder: str) -> int:
    """Build the package in a folder, its method compiled; run with it; return the exit status."""
    build = (sys.executable, "setup.py", "--quiet", "build", "--build-base", folder)
    library = f"{folder}/lib"
    asked = {**os.environ, "FUZZY_FUSION_COMPILE": "1"}
    subprocess.run([*build, "--build-lib", library], cwd=machine.ROOT, env=asked, check=True)
    found = {**os.environ, "PYTHONPATH": f"{library}:{machine.ROOT / 'test'}"}
    words = [each for each in sys.argv[1:] if each != "--compiled"]
    again = [sys.executable, "-m", "bench", *words]
    return subprocess.run(again, cwd=folder, env=found, check=False).returncode


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("bench", description=__doc__)
    parser.add_argument("--only", nargs="+", choices=list(BENCHMARKS), help="run these alone")
    parser.add_argument("--repetitions", type=int, default=FULL.repetitions, metavar="N")
    parser.add_argument(
        "--messages", type=int, metavar="N", help=f"in the largest bag {{{FULL.messages}}}"
    )
    parser.add_argument(
        "--compiled", action="store_true", help="compile the method ahead of time first"
    )
    parser.add_argument("--tiny", action="store_true", help="see whether it runs")
    return parser


if __name__ == "__main__":
    main()
