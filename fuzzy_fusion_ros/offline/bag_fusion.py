# SPDX-License-Identifier: Apache-2.0
"""The fusion on the messages of a bag, in the order in which they were recorded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from fuzzy_fusion_ros.bag.reader import BagReader
from fuzzy_fusion_ros.bag.topic import BagMessage
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.offline.recording import count_drops
from fuzzy_fusion_ros.offline.topics import Topics, codecs_of, unstamped
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.online.ticks import Ticks
from fuzzy_fusion_ros.online.verdict import Fused, Verdict
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Logged(NamedTuple):
    """An estimate, and the log time of what brought it about, nanoseconds."""

    log_ns: int
    fused: Fused


class BagFusion:
    """What a node would estimate, message by message.

    Attributes:
        s2_codec: Reads S2.
        unit: Unit of the signal, ``""`` where neither a parameter nor a type states it.
    """

    def __init__(self, bag: BagReader, topics: Topics, parameters: Parameters) -> None:
        """Settle the fields of S1 and S2.

        Raises:
            MessageError: A field is not in its type.
            ParameterError: The units of S1 and S2 differ.
        """
        self._topics = topics
        codecs = codecs_of(bag, topics, parameters, ("s1", "s2"))
        self._s1_codec, self.s2_codec = codecs["s1"], codecs["s2"]
        self.unit = signal_unit(self._s1_codec, self.s2_codec, parameters)
        self._fusion = Fusion(parameters)
        self._ticks = Ticks(parameters)

    @property
    def restarts(self) -> int:
        """How often timestamps jumped to a new timeline."""
        return self._fusion.restarts

    def before(self, log_ns: int) -> Iterator[Logged]:
        """Yield what ticks of the timer bring about by the time of the next message."""
        due_ns = self._ticks.due(log_ns)
        if due_ns is not None:
            yield from _logged(self._fusion.on_tick(), due_ns)

    def on_message(self, message: BagMessage) -> Iterator[Logged]:
        """Yield what a message brings about; one topic may be both sensors."""
        if message.topic == self._topics.s1:
            yield from _logged(self._on_s1(message), message.log_ns)
        if message.topic == self._topics.s2:
            yield from _logged(self._on_s2(message), message.log_ns)

    def notes(self) -> list[str]:
        """Return what was dropped and why, one line each; no message may follow."""
        self._fusion.finish()
        notes = unstamped(self._topics, {"s1": self._s1_codec, "s2": self.s2_codec})
        notes += count_drops(self._topics.s1, self._fusion.s1)
        notes += count_drops(self._topics.s2, self._fusion.s2)
        notes += filter(None, [self._fusion.clock_problem()])
        return notes

    def _on_s1(self, message: BagMessage) -> Verdict:
        try:
            sample = self._s1_codec.sample(message.data, message.log_ns)
        except MessageError as error:
            return _unread(self._fusion.s1, error)
        return self._fusion.on_s1(sample, message.log_ns)

    def _on_s2(self, message: BagMessage) -> Verdict:
        try:
            stamp_ns, value, _ = self.s2_codec.sample(message.data, message.log_ns)
        except MessageError as error:
            return _unread(self._fusion.s2, error)
        return self._fusion.on_s2(Sample(stamp_ns, value, message.data), message.log_ns)


def _logged(verdict: Verdict, log_ns: int) -> Iterator[Logged]:
    return (Logged(log_ns, fused) for fused in verdict.estimates)


def _unread(guard: Guard, error: MessageError) -> Verdict:
    drop = Drop.of(error)
    guard.drop(drop)
    return Verdict(drop=drop)
