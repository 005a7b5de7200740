# SPDX-License-Identifier: Apache-2.0
"""How cost grows: with the predictor's size, the length of a bag, and the number of nodes."""

from __future__ import annotations

import contextlib
import shutil
import statistics
import tempfile
from pathlib import Path

from bench.big_bag import SENSORS, write_bag
from bench.channel import Channel
from bench.child import program, running
from bench.effort import Effort
from bench.estimator import COMPLETE, FA, estimate, signals
from bench.graph import graph
from bench.measuring import compared, interleaved
from bench.replaying import replayed
from bench.table import Row
from fuzzy_fusion_ros.parameters.group import replace

SIZES = ((20, 5), (10, 5), (40, 5), (80, 5), (20, 10), (20, 20))
"""n and M of the predictor; the others are compared with the first."""

LENGTHS = (1000, 100, 10, 1)
"""Divisors of the most messages."""

NODES = (1, 2, 4)
"""Nodes that listen to the same two topics."""

RATE = 100


def rows(effort: Effort) -> list[Row]:
    """Measure CPU time; the figure is the ratio to the first row of a kind."""
    return [*_predictors(effort), *_lengths(effort), *_nodes(effort)]


def _predictors(effort: Effort) -> list[Row]:
    s1, s2 = signals(effort.steps)
    sizes = [
        replace(COMPLETE, {"predictor.samples": n, "predictor.rules": m, "predictor.lead": 2.0})
        for n, m in SIZES
    ]
    first, *others = interleaved(
        effort.repetitions, *(lambda each=each: 1e6 * estimate(each, s1, s2) for each in sizes)
    )
    return [
        _row(f"update, complete, n = {n}, M = {m}", taken, first, "n = 20, M = 5")
        for (n, m), taken in zip(SIZES, [first, *others], strict=True)
    ]


def _lengths(effort: Effort) -> list[Row]:
    lengths = [max(effort.messages // each, 100) for each in LENGTHS]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        taken = []
        for length in lengths:
            write_bag(folder / "bag", length, SENSORS)
            replay = [replayed(folder / "bag", folder / "out", FA) for _ in range(2)]
            taken.append([1e6 * min(replay) / length])
            shutil.rmtree(folder / "bag")
    return [
        _row(f"replay (FA) of {length:,} messages, per message", each, taken[0], f"{lengths[0]:,}")
        for length, each in zip(lengths, taken, strict=True)
    ]


def _nodes(effort: Effort) -> list[Row]:
    with graph() as opened, contextlib.ExitStack() as stack:
        spaces = [f"n{k}" for k in range(max(NODES))]
        to_first = [f"{topic}:=/{spaces[0]}/{topic}" for topic in ("s1", "s2")]
        children = []
        taken = []
        for number, space in enumerate(spaces, start=1):
            renamed = [word for each in (f"__ns:=/{space}", *to_first) for word in ("-r", each)]
            command = program("fusion_node", "--ros-args", *renamed)
            children.append(stack.enter_context(running(command, opened.environment)))
            if number in NODES:
                channel = Channel(opened, children[0], spaces[0])
                bursts = [channel.burst(RATE, effort.seconds) for _ in range(effort.repetitions)]
                taken.append([1e6 * statistics.median(each.cpu for each in bursts)])
    return [
        _row(f"fusion_node, FA, one of {n} on the same topics, {RATE} Hz", each, taken[0], "1 node")
        for n, each in zip(NODES, taken, strict=True)
    ]


def _row(what: str, ours: list[float], first: list[float], name: str) -> Row:
    it = compared(ours, first)
    return Row(f"{what}, CPU", f"{it.ours:.2f} µs", f"{it.against:.2f} µs, {name}", it.ratio)
