# SPDX-License-Identifier: Apache-2.0
"""The fusion on the messages of a bag, in the order in which they were recorded."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.bag.topic import BagMessage
from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.offline.recording import clock_warning, count_drops
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of, unstamped
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.joint import Joint
from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.online.verdict import Fused, Together, Verdict
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Logged(NamedTuple):
    """An estimate, and the log time of what brought it about, nanoseconds."""

    log_ns: int
    fused: Fused


class BagChannels:
    """What a node with all its channels would publish, message by message.

    Attributes:
        channels: The channels by name; a single one has none.
    """

    def __init__(self, bag: BagReader, topics: Topics, parameters: Parameters) -> None:
        """Settle the fields of S1 and S2.

        Raises:
            MessageError: A field is not in its type.
            ParameterError: The units of S1 and S2 differ.
        """
        self.channels = {
            name: BagFusion(bag, topics, own) for name, own in parameters.by_channel().items()
        }
        self._joint = Joint()
        for name, each in self.channels.items():
            self._joint.add(name, each.fusion)

    def before(self, log_ns: int) -> Iterator[tuple[int, Together]]:
        """Yield what ticks bring about by the time of the next message, with its log time."""
        return self._joined({name: each.before(log_ns) for name, each in self.channels.items()})

    def on_message(self, message: BagMessage) -> Iterator[tuple[int, Together]]:
        """Yield what a message brings about, with its log time."""
        return self._joined({n: each.on_message(message) for n, each in self.channels.items()})

    def notes(self) -> list[str]:
        """Return what was dropped and why, one line each; no message may follow."""
        notes = [
            f"{name}: {note}" if name else note
            for name, each in self.channels.items()
            for note in each.notes()
        ]
        notes += [
            f"{name}: {count} estimates skipped: {name} had no estimate at their stamps"
            for name, count in self._joint.withheld.items()
        ]
        return notes

    def _joined(self, found: Mapping[str, Iterator[Logged]]) -> Iterator[tuple[int, Together]]:
        log_ns = 0
        for name, estimates in found.items():
            for logged in estimates:
                self._joint.take(name, [logged.fused])
                log_ns = logged.log_ns
        for together in self._joint.due():
            yield log_ns, together


class BagFusion:
    """What one channel of a node would estimate, message by message.

    Attributes:
        fusion: The fusion.
        codecs: Read S1 and S2, by role.
        unit: Unit of the signal, ``""`` where neither a parameter nor a type states it.
    """

    def __init__(self, bag: BagReader, topics: Topics, parameters: Parameters) -> None:
        """Settle the fields of S1 and S2.

        Raises:
            MessageError: A field is not in its type.
            ParameterError: The units of S1 and S2 differ.
        """
        self._topics = topics
        self.codecs = codecs_of(bag, topics, parameters, ("s1", "s2"))
        self.unit = signal_unit(self.codecs["s1"], self.codecs["s2"], parameters)
        self.fusion = Fusion(parameters)
        self._ticks = Ticks(parameters)

    def before(self, log_ns: int) -> Iterator[Logged]:
        """Yield what ticks of the timer bring about by the time of the next message."""
        due_ns = self._ticks.due(log_ns)
        if due_ns is not None:
            yield from _logged(self.fusion.on_tick(), due_ns)

    def on_message(self, message: BagMessage) -> Iterator[Logged]:
        """Yield what a message brings about; one topic may be both sensors."""
        if message.topic == self._topics.s1:
            yield from _logged(self._on_s1(message), message.log_ns)
        if message.topic == self._topics.s2:
            yield from _logged(self._on_s2(message), message.log_ns)

    def notes(self) -> list[str]:
        """Return what was dropped and why, one line each; no message may follow."""
        self.fusion.finish()
        notes = unstamped(self._topics, self.codecs)
        notes += count_drops(self._topics.s1, self.fusion.s1)
        notes += count_drops(self._topics.s2, self.fusion.s2)
        notes += clock_warning(self.fusion.clock_problem())
        return notes

    def _on_s1(self, message: BagMessage) -> Verdict:
        try:
            sample = self.codecs["s1"].sample(message.data, message.log_ns)
        except MessageError as error:
            return _unread(self.fusion.s1, error)
        return self.fusion.on_s1(sample, message.log_ns)

    def _on_s2(self, message: BagMessage) -> Verdict:
        try:
            sample = self.codecs["s2"].sample(message.data, message.log_ns, message.data)
        except MessageError as error:
            return _unread(self.fusion.s2, error)
        return self.fusion.on_s2(sample, message.log_ns)


def _logged(verdict: Verdict, log_ns: int) -> Iterator[Logged]:
    return (Logged(log_ns, fused) for fused in verdict.estimates)


def _unread(guard: Guard, error: MessageError) -> Verdict:
    drop = Drop.of(error)
    guard.drop(drop)
    return Verdict(drop=drop)
