# SPDX-License-Identifier: Apache-2.0
"""One sensor as a node sees it: any message type in, dated samples out."""

from __future__ import annotations

from collections.abc import Callable

from fuzzy_fusion_ros.core.numerics import seconds_between
from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.units import unit_read
from fuzzy_fusion_ros.nodes.source import Sources
from fuzzy_fusion_ros.online.guard import Drop, Guard
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import SensorParameters
from fuzzy_fusion_ros.ros.clock import NodeTime

RESTARTS_SAID_EVERY = 10.0
"""Shortest time between two log lines about timestamps that jump back, seconds."""


class SensorInput:
    """Reads a sensor's messages.

    Attributes:
        codec: Reads them.
        guard: Counts what becomes of the samples.
        subscription: Where the messages come from; others may read them too.
        last_problem: What the last unreadable message lacked; empty if none was.
    """

    def __init__(
        self,
        sources: Sources,
        node_time: NodeTime,
        topic: str,
        parameters: SensorParameters,
        guard: Guard,
        on_sample: Callable[[Sample, int, int], None],
    ) -> None:
        """Subscribe.

        Args:
            sources: What the node reads.
            node_time: Its clocks.
            topic: The topic, remapped or not.
            parameters: Type and field.
            guard: Of the sensor.
            on_sample: Called with each sample, as :meth:`Reader.take`.

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
        self.take = on_sample
        self._time = node_time
        self._heard_ns = node_time.age_ns()
        self.subscription = sources.add(topic, self)

    def described(self) -> str:
        """Return topic, field, type and, if it is known, unit in words."""
        field, type_name = self.codec.field.text, self.codec.type_name
        unit = unit_read(self.codec)
        measured = f" in {unit}" if unit else ""
        return f"{self.subscription.topic}, {field} of {type_name}{measured}"

    def read(self, data: bytes, now_ns: int, stamp_ns: int | None = None) -> Sample | None:
        """Read a message; ``None`` if it cannot be read, which is counted.

        Args:
            data: The message.
            now_ns: Time of receipt, nanoseconds.
            stamp_ns: Its stamp, if another input has read it.
        """
        try:
            if stamp_ns is None:
                return self.codec.sample(data, now_ns, data)
            return Sample(stamp_ns, self.codec.value(data), data)
        except MessageError as error:
            self.guard.drop(Drop.of(error))
            self.last_problem = str(error)
            return None

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
