"""One sensor of any message type, republished as a stamped scalar."""

from __future__ import annotations

import functools
from typing import Any

from fuzzy_fusion_ros.messages import InstalledTypes
from fuzzy_fusion_ros.messages.outputs import POINT, point_template
from fuzzy_fusion_ros.nodes.parameters import SubscriberParameters
from fuzzy_fusion_ros.nodes.sensor_report import SensorReport
from fuzzy_fusion_ros.online.guard import Guard
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Diagnostics
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.ros.subscription import Received, SensorInput


class SensorSubscriber(ConfiguredNode[SubscriberParameters]):
    """Takes ``input``, drops what cannot be used, and publishes the rest as ``output``."""

    def __init__(self, **options: Any) -> None:
        """Make the node; ``options`` as :class:`ConfiguredNode` takes them.

        Raises:
            FusionError: A parameter, the message type or the field cannot be used.
        """
        super().__init__("sensor_subscriber", SubscriberParameters(), **options)

    def set_up(self) -> None:
        """Subscribe, publish, report."""
        node_time = NodeTime(self)
        self._guard = Guard()
        self._input = SensorInput(
            self,
            node_time,
            "input",
            self.parameters.input,
            input_profile(self.parameters.qos),
            self._guard,
            self.recorder,
            self._on_sample,
            lambda: self.parameters.future_tolerance,
        )
        self._output = RecordingPublisher(self, "output", POINT, self.recorder)
        self._point = functools.lru_cache(functools.partial(point_template, InstalledTypes()))
        report = SensorReport(
            "input", self._input, self._guard, lambda: self.parameters.input.timeout
        )
        self._diagnostics = Diagnostics(self, node_time, report)

    def _on_sample(self, received: Received) -> bool:
        parameters = self.parameters
        admitted = self._guard.take(
            received.sample,
            received.now_ns,
            parameters.future_tolerance,
            parameters.input.timeout,
            self._on_jump_back,
        )
        if admitted:
            sample = received.sample
            point = self._point(self._input.codec.frame(received.data))
            self._output.send(point.filled(sample.value, sample.stamp_ns), received.log_ns)
        return admitted

    def _on_jump_back(self) -> None:
        self._guard.restart()
        self.log.warning("stamps have jumped back: passing them on from here")
