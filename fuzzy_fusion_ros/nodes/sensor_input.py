# SPDX-License-Identifier: Apache-2.0
"""One sensor as a node sees it: any message type in, dated samples out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.units import unit_read
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import SensorParameters
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.ros.subscription import RawSubscription


class Received(NamedTuple):
    """A message that came in.

    Attributes:
        sample: The sample in it, whatever it holds, with the message.
        now_ns: Time of receipt on the node's clock, nanoseconds.
        log_ns: The time to record it, and all that follows from it, at.
    """

    sample: Sample
    now_ns: int
    log_ns: int


class SensorInput:
    """Subscribes to a sensor, reads its messages and records them.

    Attributes:
        codec: Reads the messages.
        guard: Counts what becomes of the samples.
        subscription: Where they come from.
        last_problem: What the last unreadable message lacked; empty if none was.
    """

    def __init__(
        self,
        node: ConfiguredNode[Any],
        node_time: NodeTime,
        topic: str,
        parameters: SensorParameters,
        guard: Guard,
        on_message: Callable[[bytes], None],
    ) -> None:
        """Subscribe.

        Args:
            node: The node to subscribe for; its parameters have ``qos`` and ``future_tolerance``.
            node_time: Its clocks.
            topic: The topic, remapped or not.
            parameters: Type and field.
            guard: Of the sensor.
            on_message: Called with each message.

        Raises:
            MessageError: The type is not installed or has no such field.
        """
        self.codec = ScalarCodec(
            InstalledTypes(),
            parameters.type,
            parameters.field,
            parameters.scale,
            parameters.offset,
        )
        self.guard = guard
        self.last_problem = ""
        self._node = node
        self._time = node_time
        self._heard_ns = node_time.age_ns()
        self._warned = self.codec.is_stamped
        profile = input_profile(node.parameters.qos)
        self.subscription = RawSubscription(node, topic, self.codec.type_name, profile, on_message)
        node.recorder.add(self.subscription.topic, self.codec.type_name, profile)

    def described(self) -> str:
        """Return topic, field, type and, if it is known, unit in words."""
        field, type_name = self.codec.field.text, self.codec.type_name
        unit = unit_read(self.codec)
        measured = f" in {unit}" if unit else ""
        return f"{self.subscription.topic}, {field} of {type_name}{measured}"

    def receive(self, data: bytes) -> Received | None:
        """Read and record a message; ``None`` if it cannot be read, which is counted."""
        now_ns = self._time.now_ns()
        try:
            stamp_ns, value, _ = self.codec.sample(data, now_ns)
        except MessageError as error:
            self.guard.drop(Drop.of(error))
            self.last_problem = str(error)
            self._node.recorder.write(self.subscription.topic, now_ns, data)
            return None
        if not self._warned:
            self._warn_unstamped()
        received = self._dated(Sample(stamp_ns, value, data), now_ns)
        self._node.recorder.write(self.subscription.topic, received.log_ns, data)
        return received

    def admitted(self) -> None:
        """Take note that a sample is of use: the sensor is not silent."""
        self._heard_ns = self._time.age_ns()

    @property
    def age(self) -> float:
        """Time since the last sample of use came, or since the start, seconds."""
        now_ns = self._time.age_ns()
        if self._heard_ns == 0 or self._heard_ns > now_ns:  # /clock has started or jumped back
            self._heard_ns = now_ns
        return seconds_between(self._heard_ns, now_ns)

    def _dated(self, sample: Sample, now_ns: int) -> Received:
        """Say when a message came; simulated runs are dated by stamps, so that they repeat."""
        if not self._time.simulated:
            return Received(sample, now_ns, now_ns)
        if now_ns == 0:  # /clock has not come yet
            now_ns = sample.stamp_ns
        ahead = seconds_between(now_ns, sample.stamp_ns)
        is_future = ahead > self._node.parameters.future_tolerance
        return Received(sample, now_ns, now_ns if is_future else sample.stamp_ns)

    def _warn_unstamped(self) -> None:
        self._warned = True
        self._node.log.warning(
            f"{self.subscription.topic}: {self.codec.type_name} has no timestamp; using receive "
            "time, so transport delay will look like motion"
        )
