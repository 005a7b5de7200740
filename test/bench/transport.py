# SPDX-License-Identifier: Apache-2.0
"""fusion_node against the bare relay: CPU and latency per sample, and where it saturates.

All processes run from beginning to end; one at a time gets samples, in turn.
"""

from __future__ import annotations

import contextlib

from bench.channel import Burst, Channel
from bench.child import module, program, running
from bench.effort import Effort
from bench.graph import Graph, graph
from bench.measuring import compared
from bench.relay import DEFAULT, EVENTS, RAW
from bench.table import Aim, Row, at_least, at_most

FA, COMPLETE, RELAY, PLAIN = "fa", "complete", "relay", "plain_relay"
BYTES = "bytes_relay"
THREE = "three"
AXES = ("x", "y", "z")
PROFILE = "sensor_data"
BOUNDS = {FA: 1.10, COMPLETE: 1.25}
"""Of latencies, as multiples of the relay's."""

CPU_BOUNDS = {FA: 0.9, COMPLETE: 1.0}
"""Of CPU time likewise: the relay makes messages of the bytes, the node does not."""

BURSTS = (FA, THREE, COMPLETE, RELAY, BYTES)


def rows(effort: Effort) -> list[Row]:
    """Measure all."""
    with graph() as opened, contextlib.ExitStack() as stack:
        channels = {
            name: Channel(opened, stack.enter_context(running(command, opened.environment)), name)
            for name, command in commands(opened).items()
        }
        found = []
        for rate in effort.rates:
            bursts: dict[str, list[Burst]] = {name: [] for name in BURSTS}
            for _ in range(effort.repetitions):
                for name, list_ in bursts.items():
                    list_.append(channels[name].burst(rate, effort.seconds))
            found += [row for name in BOUNDS for row in _burst_rows(name, rate, bursts)]
            three = f"fusion_node, three channels, {rate} Hz: CPU per sample"
            found.append(_row(three, "cpu", bursts[THREE], bursts[FA], at_most(1.5), "one channel"))
        return found + _saturation_rows(channels, effort)


def commands(opened: Graph) -> dict[str, list[str]]:
    """Return how to start what is measured, by namespaces."""

    def arguments(name: str) -> list[str]:
        return ["--ros-args", "-r", f"__ns:=/{name}"]

    predicting = ["-p", "predictor.enabled:=true"]
    fields = [f"{axis}.{role}.field:=point.{axis}" for axis in AXES for role in ("s1", "s2")]
    settings = [f"channels:={list(AXES)}", *fields]
    channels = [word for each in settings for word in ("-p", each)]
    return {
        FA: program("fusion_node", *arguments(FA)),
        THREE: program("fusion_node", *arguments(THREE), *channels),
        COMPLETE: program("fusion_node", *arguments(COMPLETE), *predicting),
        RELAY: module("relay", EVENTS, PROFILE, *arguments(RELAY)),
        PLAIN: module("relay", DEFAULT, PROFILE, *arguments(PLAIN)),
        BYTES: module("relay", RAW, PROFILE, *arguments(BYTES)),
    }


def _burst_rows(name: str, rate: int, bursts: dict[str, list[Burst]]) -> list[Row]:
    aim = at_most(BOUNDS[name])
    ours, relays = bursts[name], bursts[RELAY]
    lost = sum(each.lost for each in ours) / len(ours)
    what = f"fusion_node, {name}, {rate} Hz"
    return [
        _row(f"{what}: CPU per sample", "cpu", ours, relays, at_most(CPU_BOUNDS[name])),
        _row(f"{what}: CPU per sample", "cpu", ours, bursts[BYTES], None, "relay of bytes"),
        _row(f"{what}: median latency", "median", ours, relays, aim),
        _row(f"{what}: p99 latency ({lost:.1%} lost)", "p99", ours, relays, aim),
    ]


def _row(
    what: str,
    figure: str,
    ours: list[Burst],
    relays: list[Burst],
    aim: Aim | None,
    other: str = "relay",
) -> Row:
    it = compared(
        [getattr(each, figure) for each in ours], [getattr(each, figure) for each in relays]
    )
    return Row(what, f"{it.ours * 1e6:.0f} µs", f"{it.against * 1e6:.0f} µs {other}", it.ratio, aim)


def _saturation_rows(channels: dict[str, Channel], effort: Effort) -> list[Row]:
    turns: dict[str, list[tuple[float, float]]] = {name: [] for name in channels}
    for _ in range(effort.repetitions):
        for name, channel in channels.items():
            turns[name].append(channel.saturate(effort.seconds))
    found = []
    for name in (FA, COMPLETE):
        for other, text, aim in (
            (RELAY, "relay", None),
            (PLAIN, "relay on rclpy's default executor", at_least(2.0)),
        ):
            for column, unit in enumerate(("/s", "/s of its CPU")):
                it = compared(
                    [each[column] for each in turns[name]], [each[column] for each in turns[other]]
                )
                found.append(
                    Row(
                        f"fusion_node, {name}: saturation",
                        f"{it.ours:.0f} {unit}",
                        f"{it.against:.0f} {unit} {text}",
                        it.ratio,
                        aim if column == 0 else None,
                    )
                )
    return found
