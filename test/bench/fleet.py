# SPDX-License-Identifier: Apache-2.0
"""Many short bags against one long bag of as many samples; memory of score and tune."""

from __future__ import annotations

import os
import statistics
import subprocess
import tempfile
from pathlib import Path

from bench.big_bag import write_bag
from bench.child import environment, program
from bench.effort import Effort
from bench.table import Row, at_most
from fuzzy_fusion_ros.baselines import BaselineParameters
from fuzzy_fusion_ros.jobs import parameter_file
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.parameters.fusion import Parameters

SHORT = 1000
"""Messages of a short bag."""

TOPICS = (("/truth", POINT, 1), ("/s2", POINT, 10), ("/s1", POINT, 1))

MORE = at_most(1.2)
LIMIT = at_most(6.0, "GB")
ENOUGH = 100_000
"""Messages from which on growth of memory stands out from its noise."""

DAY = 95_000_000
"""Messages of a day at 1 kHz."""


def rows(effort: Effort) -> list[Row]:
    """Run score and check over many bags and over one; report CPU time and the most memory."""
    count = max(effort.messages // SHORT, 2)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        params = folder / "params.yaml"
        params.write_text(parameter_file.text(Parameters(), {"": BaselineParameters()}), "utf-8")
        short = [folder / f"short_{k}" for k in range(count)]
        for each in short:
            write_bag(each, SHORT, TOPICS)
        write_bag(folder / "long", count * SHORT, TOPICS)
        many, one = [str(each) for each in short], [str(folder / "long")]
        found = []
        for command, options in (("score", ["--params", str(params)]), ("check", [])):
            costs = [
                (_run(command, many, options), _run(command, one, options))
                for _ in range(effort.repetitions)
            ]
            ours, against = (statistics.median(pair[k][0] for pair in costs) for k in range(2))
            found.append(
                Row(
                    f"{command}, {count} bags of {SHORT} messages, CPU",
                    f"{ours:.1f} s",
                    f"{against:.1f} s, one bag of as many",
                    ours / against,
                    MORE,
                )
            )
            if command == "score" and count * SHORT >= ENOUGH:
                short_gb, long_gb = (costs[0][k][1] for k in range(2))
                found.append(_day(command, short_gb, long_gb, count * SHORT))
        return found


def _day(command: str, short: float, long: float, messages: int) -> Row:
    """Carry memory on to the bag of a day by its growth from short bags to a long one.

    Args:
        command: What was run.
        short: Most memory over the short bags, GB.
        long: Most memory over the long bag, GB.
        messages: In the long bag.
    """
    each = max(long - short, 0.0) / (messages - SHORT)
    day = long + each * (DAY - messages)
    what = f"{command}: peak memory, carried on from {messages:,} to {DAY:,} messages"
    return Row(what, f"{day:.1f} GB", f"{each * 1e9:.0f} bytes a message", day, LIMIT)


def _run(command: str, bags: list[str], options: list[str]) -> tuple[float, float]:
    """Return CPU time, seconds, and the most memory, GB, of a command over bags."""
    child = subprocess.Popen(
        program(command, *bags, *options),
        env=environment({}),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode not in {0, 1}:  # 1: check has found something
        raise RuntimeError(f"{command} exited {child.returncode}")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1e6
