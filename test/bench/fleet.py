# SPDX-License-Identifier: Apache-2.0
"""Many short bags against one long bag of as many samples."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

from bench.big_bag import write_bag
from bench.child import environment, program
from bench.effort import Effort
from bench.measuring import compared
from bench.table import Row, at_most
from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.jobs import parameter_file
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.parameters.fusion import Parameters

SHORT = 1000
"""Messages of a short bag."""

TOPICS = (("/truth", POINT, 1), ("/s2", POINT, 10), ("/s1", POINT, 1))

MORE = at_most(1.2)


def rows(effort: Effort) -> list[Row]:
    """Run score and check over many bags and over one; report CPU time."""
    count = max(effort.messages // SHORT, 2)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        params = folder / "params.yaml"
        params.write_text(parameter_file.text(Parameters(), {"": BaselineParameters()}), "utf-8")
        short = [folder / f"short_{k}" for k in range(count)]
        for each in short:
            write_bag(each, SHORT, TOPICS)
        write_bag(folder / "long", count * SHORT, TOPICS)
        many, one = [str(each) for each in short], [str(folder / "long")]
        found_in = ["--json", str(folder / "found.json")]
        found = []
        for command, options in (
            ("score", ["--params", str(params)]),
            ("check", []),
            ("check --json", found_in),
        ):
            name = command.partition(" ")[0]
            costs = [
                (_run(name, many, options), _run(name, one, options))
                for _ in range(effort.repetitions)
            ]
            it = compared(*(list(each) for each in zip(*costs, strict=True)))
            found.append(
                Row(
                    f"{command}, {count} bags of {SHORT} messages, CPU",
                    f"{it.ours:.1f} s",
                    f"{it.against:.1f} s, one bag of as many",
                    it.ratio,
                    MORE,
                )
            )
        return found


def _run(command: str, bags: list[str], options: list[str]) -> float:
    """Return CPU time of a command over bags, seconds, with one thread for BLAS.

    Of several, those that wait spin: up to 2 s of a long bag's score, on a busy machine.
    """
    child = subprocess.Popen(
        program(command, *bags, *options),
        env=environment({"OPENBLAS_NUM_THREADS": "1"}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in {0, 1}:  # 1: check has found something
        raise RuntimeError(f"{command} exited {child.returncode}")
    return used.ru_utime + used.ru_stime
