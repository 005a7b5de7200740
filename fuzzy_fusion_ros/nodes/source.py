# SPDX-License-Identifier: Apache-2.0
"""A topic and all that read it: each message is received, dated and recorded once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import ScalarCodec
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.ros.subscription import RawSubscription


class Reader(Protocol):
    """Reads the messages of a topic.

    Attributes:
        codec: What it takes from them.
    """

    codec: ScalarCodec

    def read(self, data: bytes, now_ns: int, stamp_ns: int | None = None) -> Sample | None:
        """Return the sample in a message, ``None`` if it cannot be read.

        Args:
            data: The message.
            now_ns: Time of receipt, nanoseconds.
            stamp_ns: Its stamp, if another reader has read it.
        """

    def take(self, sample: Sample, now_ns: int, log_ns: int) -> None:
        """Use a sample.

        Args:
            sample: The sample of a message, whatever it holds, with the message.
            now_ns: Time of receipt on the node's clock, nanoseconds.
            log_ns: The time to record the message, and all that follows from it, at.
        """


class Sources:
    """The topics that a node reads, each subscribed to once, however many read it."""

    def __init__(
        self,
        node: ConfiguredNode[Any],
        node_time: NodeTime,
        after: Callable[[int], None] = lambda log_ns: None,
    ) -> None:
        """Subscribe to nothing yet.

        Args:
            node: The node to subscribe for; its parameters have ``qos`` and ``future_tolerance``.
            node_time: Its clocks.
            after: Called when all have used a message, with the time it was recorded at.
        """
        self._node = node
        self._time = node_time
        self._after = after
        self._sources: dict[str, _Source] = {}

    def add(self, topic: str, reader: Reader) -> RawSubscription:
        """Give the messages of a topic to a reader too; return where they come from.

        Args:
            topic: The topic, remapped or not.
            reader: Reads them after those added before.

        Raises:
            MessageError: The type is not installed, or not that of those added before.
            ParameterError: A ``qos_overrides`` parameter is wrong.
        """
        name, type_name = self._node.resolve_topic_name(topic), reader.codec.type_name
        if name not in self._sources:
            self._sources[name] = _Source(self._node, self._time, topic, reader.codec, self._after)
        source = self._sources[name]
        if source.subscription.type_name != type_name:
            raise MessageError(
                f"{name} is configured as {source.subscription.type_name} and as {type_name}, but "
                "a topic has one type: use the same type for both"
            )
        source.readers.append(reader)
        return source.subscription

    def work(self) -> list[float]:
        """Return how long each message took since the last call, seconds."""
        return [each for source in self._sources.values() for each in source.work()]


class _Source:
    """One topic of one type."""

    def __init__(
        self,
        node: ConfiguredNode[Any],
        node_time: NodeTime,
        topic: str,
        codec: ScalarCodec,
        after: Callable[[int], None],
    ) -> None:
        self.readers: list[Reader] = []
        self._node = node
        self._time = node_time
        self._after = after
        self._warned = codec.is_stamped
        profile = input_profile(node.parameters.qos)
        self.subscription = RawSubscription(node, topic, codec.type_name, profile, self._on_message)
        node.recorder.add(self.subscription.topic, codec.type_name, profile)

    def work(self) -> list[float]:
        return self.subscription.work.drain()

    def _on_message(self, data: bytes) -> None:
        now_ns = log_ns = self._time.now_ns()
        stamp_ns, samples = None, []
        for reader in self.readers:
            sample = reader.read(data, now_ns, stamp_ns)
            if sample is not None:
                stamp_ns = sample.stamp_ns
                samples.append((reader, sample))
        if stamp_ns is not None:
            if not self._warned:
                self._warn_unstamped()
            if self._time.simulated:
                now_ns, log_ns = self._dated(stamp_ns, now_ns)
        self._node.recorder.write(self.subscription.topic, log_ns, data)
        for reader, sample in samples:
            reader.take(sample, now_ns, log_ns)
        self._after(log_ns)

    def _dated(self, stamp_ns: int, now_ns: int) -> tuple[int, int]:
        """Say when a message came in a simulated run: it is dated by stamps, so that it repeats.

        Args:
            stamp_ns: The message's stamp.
            now_ns: Time of receipt, nanoseconds.

        Returns:
            Time of receipt and time to record it at, nanoseconds.
        """
        if now_ns == 0:  # /clock has not come yet
            now_ns = stamp_ns
        is_future = seconds_between(now_ns, stamp_ns) > self._node.parameters.future_tolerance
        return now_ns, now_ns if is_future else stamp_ns

    def _warn_unstamped(self) -> None:
        self._warned = True
        self._node.log.warning(
            f"{self.subscription.topic}: {self.subscription.type_name} has no timestamp; using "
            "receive time, so transport delay will look like motion"
        )
