# SPDX-License-Identifier: Apache-2.0
"""How cost grows: with the predictor's size, the length of a bag, and the number of nodes."""

from __future__ import annotations

import contextlib
import itertools
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
"""How many nodes listen to the same two topics."""

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
    """Measure what each further message costs, so that starting counts for none."""
    lengths = sorted({max(effort.messages // each, 100) for each in LENGTHS})
    with tempfile.TemporaryDirectory() as name:
        bags = [Path(name) / f"bag_{length}" for length in lengths]
        for bag, length in zip(bags, lengths, strict=True):
            write_bag(bag, length, SENSORS)
        replayed(bags[-1], Path(name) / "out", FA)  # loads what is compiled
        taken = interleaved(
            effort.repetitions,
            *(lambda each=each: 1e6 * replayed(each, Path(name) / "out", FA) for each in bags),
        )
    spans = list(itertools.pairwise(lengths))
    each_further = [
        [(more - less) / (end - begin) for less, more in zip(*both, strict=True)]
        for both, (begin, end) in zip(itertools.pairwise(taken), spans, strict=True)
    ]
    first = "{:,} to {:,}".format(*spans[0])
    return [
        _row(f"replay (FA), each message from {begin:,} to {end:,}", each, each_further[0], first)
        for (begin, end), each in zip(spans, each_further, strict=True)
    ]


def _nodes(effort: Effort) -> list[Row]:
    """Measure the first of some nodes on the same topics; all nodes run all the time."""
    with graph() as opened, contextlib.ExitStack() as stack:
        channels = []
        for number in NODES:
            topics = [f"{topic}:=/of{number}/{topic}" for topic in ("s1", "s2")]
            children = []
            for k in range(number):
                renames = [f"__ns:=/of{number}/n{k}", *topics]
                renamed = [word for each in renames for word in ("-r", each)]
                command = program("fusion_node", "--ros-args", *renamed)
                children.append(stack.enter_context(running(command, opened.environment)))
            to, answers = f"/of{number}", f"/of{number}/n0"
            channels.append(Channel(opened, children[0], to, answers, listeners=number))
        for channel in channels:
            channel.warm_up()
        taken = interleaved(
            effort.repetitions,
            *(lambda each=each: 1e6 * each.burst(RATE, effort.seconds).cpu for each in channels),
        )
    return [
        _row(f"fusion_node, FA, one of {n} on the same topics, {RATE} Hz", each, taken[0], "1 node")
        for n, each in zip(NODES, taken, strict=True)
    ]


def _row(what: str, ours: list[float], first: list[float], name: str) -> Row:
    it = compared(ours, first)
    return Row(f"{what}, CPU", f"{it.ours:.2f} µs", f"{it.against:.2f} µs, {name}", it.ratio)
