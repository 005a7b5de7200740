# SPDX-License-Identifier: Apache-2.0
"""Replay: a bag through the same fusion as in the node, into a new bag.

Reads straight through: messages in log order, samples, ``Fusion``, messages.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path
from typing import NamedTuple

from fuzzy_fusion_ros.bag.block import Block
from fuzzy_fusion_ros.bag.metadata import offered_qos
from fuzzy_fusion_ros.bag.reader import BagReader, open_bag
from fuzzy_fusion_ros.bag.topic import UNDESCRIBED, BagMessage, Topic
from fuzzy_fusion_ros.bag.writer import BagWriter
from fuzzy_fusion_ros.messages.explanation_rows import ExplanationRows
from fuzzy_fusion_ros.messages.outputs import (
    EXPLANATION,
    EstimateMessages,
    EstimateSource,
    explain,
    point_template,
)
from fuzzy_fusion_ros.offline.bag_fusion import BagChannels
from fuzzy_fusion_ros.offline.bulk import Bulk
from fuzzy_fusion_ros.offline.topics import Topics, explanation_prefix, explanation_topics
from fuzzy_fusion_ros.offline.tracks import Progress
from fuzzy_fusion_ros.online.clocks import duration
from fuzzy_fusion_ros.online.mode_shares import ModeShares
from fuzzy_fusion_ros.online.verdict import Together
from fuzzy_fusion_ros.parameters.errors import BagError, MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters


class Replayed(NamedTuple):
    """Result of a replay.

    Attributes:
        messages: Messages of the input that were copied.
        estimates: Estimates that were written.
        restarts: How often time jumped back.
        modes: The share of time in each mode, 0 to 1, by name.
        notes: What was left out, and why, one line each.
    """

    messages: int
    estimates: int
    restarts: int
    modes: dict[str, float]
    notes: tuple[str, ...]


def replay(
    bag: BagReader,
    output: str | Path,
    topics: Topics,
    parameters: Parameters,
    start_s: float | None = None,
    end_s: float | None = None,
    progress: Progress = lambda blocks: blocks,
    *,
    explained: bool = True,
) -> Replayed:
    """Run a bag through the fusion into a new bag.

    The new bag holds the messages of the old one, bytes unchanged, without its estimates and their
    explanation; and after each message what the node would have published because of it, at the
    same log time. Memory does not grow with the bag.

    Args:
        bag: The bag; S1 and S2 must be in it.
        output: Directory of the new bag.
        topics: Where S1 and S2 are, and where the estimate goes.
        parameters: Of the fusion.
        start_s: Where to begin, seconds from the bag's first message.
        end_s: Where to end, before this.
        progress: Passes blocks of messages on.
        explained: Whether to write the explanation topics as well as the estimate.

    Raises:
        BagError: S1 or S2 is not in the bag, nothing is in the span, there is no estimate, or the
            new bag cannot be written.
        MessageError: A field is not in its type.
        KeyboardInterrupt: It was interrupted; the new bag holds what came before.
    """
    topics = topics.found_in(bag)
    topics.require_in(bag)
    bag.require_messages_from(start_s)
    if topics.estimate in {topics.s1, topics.s2}:
        raise BagError(f"topic {topics.estimate} cannot be both a sensor and the estimate")
    share = bag.share(start_s, end_s)
    station = _Station(bag, topics, parameters, share=share, explained=explained)
    written = {topics.estimate, *explanation_topics(bag, topics.estimate)}
    copied = 0
    with _new_bag(output, bag, share) as writer:
        for topic in bag.topics.values():
            if topic.name not in written:
                _declare(writer, topic)
        for name, msgtype in station.outputs.items():
            writer.add_topic(name, msgtype, qos=[offered_qos()])
        kept = [name for name in bag.topics if name not in written]
        for block in progress(bag.blocks(kept, start_s, end_s)):
            copied += block.at.size
            whole = station.on_block(block)
            if whole is not None:
                writer.write_block(whole)
                continue
            for message in block.messages():
                for out in station.before(message.log_ns):
                    writer.write(*out)
                writer.write(*message)
                for out in station.on_message(message):
                    writer.write(*out)
    if not station.written:
        raise BagError(f"bag {str(bag.path)!r} gives no estimate: {station.why_none()}")
    return station.result(copied)


def differences(one: str | Path, other: str | Path, topics: Collection[str]) -> list[str]:
    """Return how the messages of two bags differ on some topics, one line each; log times aside.

    Args:
        one: A bag.
        other: Another.
        topics: The topics; each must be in both.

    Raises:
        BagError: A bag cannot be read.
    """
    found = []
    with open_bag(one) as left, open_bag(other) as right:
        for topic in topics:
            pairs = zip_longest(left.messages([topic]), right.messages([topic]))
            at = next((k for k, (a, b) in enumerate(pairs) if not _equal(a, b)), None)
            if at is not None:
                found.append(f"{topic} differs from message {at} on")
            elif topic not in left.topics or topic not in right.topics:
                found.append(f"{topic} is not in both bags")
    return found


def _equal(one: BagMessage | None, other: BagMessage | None) -> bool:
    if one is None or other is None:
        return False
    return (one.msgtype, one.data) == (other.msgtype, other.data)


@contextmanager
def _new_bag(output: str | Path, bag: BagReader, share: float) -> Iterator[BagWriter]:
    """Context manager: a new bag for a share of another's time.

    Raises:
        KeyboardInterrupt: It was interrupted; it says how much of that time the new bag holds.
    """
    writer = BagWriter(output, bag.types)
    try:
        with writer:
            yield writer
    except KeyboardInterrupt:
        first_ns, last_ns = writer.span_ns
        whole_s = share * ((bag.end_ns or 0) - (bag.start_ns or 0)) * 1e-9
        raise KeyboardInterrupt(
            f"{output} holds the first {duration((last_ns - first_ns) * 1e-9)} of "
            f"{duration(whole_s)}"
        ) from None


def _declare(writer: BagWriter, topic: Topic) -> None:
    name, msgtype, encoding = topic.name, topic.msgtype, topic.encoding
    definition = topic.definition
    try:
        writer.add_topic(name, msgtype, qos=topic.qos, definition=definition, encoding=encoding)
    except BagError:  # nobody knows the type: copy its messages as they came
        writer.add_topic(name, msgtype, qos=topic.qos, definition=UNDESCRIBED, encoding=encoding)


class _Station:
    """The fusion between messages in and messages out.

    Attributes:
        outputs: The topics that it writes, and their types.
        written: Estimates that were written.
    """

    def __init__(
        self,
        bag: BagReader,
        topics: Topics,
        parameters: Parameters,
        *,
        share: float,
        explained: bool,
    ) -> None:
        self._bag = bag
        self._topics = topics
        self._fusion = BagChannels(bag, topics, parameters)
        self._explained = explained
        self._point = point_template(bag.types)
        channels = self._fusion.channels
        own = parameters.by_channel()
        self._estimates = EstimateMessages(
            bag.types,
            {name: EstimateSource(own[name].estimate, channels[name].codecs["s2"]) for name in own},
        )
        self._prefixes = {name: explanation_prefix(topics.estimate, name) for name in channels}
        self.outputs = {topics.estimate: self._estimates.type_name}
        for prefix in self._prefixes.values() if explained else ():
            self.outputs |= {prefix + name: kind for name, kind in EXPLANATION.items()}
        self._modes = {name: ModeShares() for name in channels}
        first = next(iter(channels))
        self._bulk = Bulk(
            topics,
            own[first],
            channels[first].codecs,
            self._estimates,
            ExplanationRows(bag.types) if explained else None,
            self.outputs,
            round(share * (bag.topics[topics.s1].message_count or 0)),
        )
        self._unwritable = 0
        self._obstacle = ""
        self.written = 0

    def on_block(self, block: Block) -> Block | None:
        """Return messages with what they bring about; ``None`` if they must go one by one."""
        channels = self._fusion.channels
        if len(channels) > 1:  # they share messages
            return None
        ((name, channel),) = channels.items()
        brought = self._bulk.follow(block, channel.fusion, self._modes[name])
        if brought is None:
            return None
        self.written += brought.estimates
        return brought.block

    def before(self, log_ns: int) -> Iterator[BagMessage]:
        """Yield what ticks bring about by the time of the next message."""
        yield from self._publish(self._fusion.before(log_ns))

    def on_message(self, message: BagMessage) -> Iterator[BagMessage]:
        """Yield what a message brings about."""
        yield from self._publish(self._fusion.on_message(message))

    def result(self, copied: int) -> Replayed:
        """Return what was done."""
        return Replayed(
            copied,
            self.written,
            max(each.fusion.restarts for each in self._fusion.channels.values()),
            {
                f"{name} {mode}" if name else mode: share
                for name, modes in self._modes.items()
                for mode, share in modes.shares().items()
            },
            (*self._notes(), *self._bag.problems),
        )

    def why_none(self) -> str:
        """Say why there is no estimate."""
        reasons = [*self._notes(), *self._bag.problems]
        return "; ".join(reasons) or "no message of S1 and S2 in this span"

    def _notes(self) -> list[str]:
        notes = self._fusion.notes()
        notes += [
            f"{name}: {count} estimates written without it; its field is that of S2"
            for name, count in self._estimates.lacking.items()
        ]
        if self._unwritable:
            notes.append(
                f"{self._unwritable} estimates do not fit into {self._estimates.type_name}: "
                f"{self._obstacle}"
            )
        return notes

    def _publish(self, estimates: Iterable[tuple[int, Together]]) -> Iterator[BagMessage]:
        for log_ns, together in estimates:
            for channel, fused in together.fused.items():
                self._modes[channel].see(fused.estimate.mode, fused.stamp_ns)
            try:
                data = self._estimates.message(together)
            except MessageError as error:
                self._unwritable += 1
                self._obstacle = self._obstacle or self._say_obstacle(together, error)
                continue
            self.written += 1
            yield self._message(self._topics.estimate, log_ns, data)
            for channel, fused in together.fused.items() if self._explained else ():
                for name, data in explain(self._point, fused):
                    yield self._message(self._prefixes[channel] + name, log_ns, data)

    def _say_obstacle(self, together: Together, error: MessageError) -> str:
        if together.s2_message:
            return str(error)
        return f"there is no message of {self._topics.s2} to copy the estimate into ({error})"

    def _message(self, topic: str, log_ns: int, data: bytes) -> BagMessage:
        return BagMessage(topic, self.outputs[topic], log_ns, data)
