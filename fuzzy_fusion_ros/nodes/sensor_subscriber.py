# SPDX-License-Identifier: Apache-2.0
"""One sensor of any message type, republished as a stamped scalar."""

from __future__ import annotations

import functools
from typing import Any

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages import InstalledTypes
from fuzzy_fusion_ros.messages.outputs import POINT, point_template
from fuzzy_fusion_ros.nodes.parameters import SubscriberParameters
from fuzzy_fusion_ros.nodes.sensor_input import RESTARTS_SAID_EVERY, SensorInput
from fuzzy_fusion_ros.nodes.sensor_report import SensorReport
from fuzzy_fusion_ros.nodes.source import Sources
from fuzzy_fusion_ros.online.guard import Guard
from fuzzy_fusion_ros.online.timeline import Timeline
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Diagnostics, Report
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher


class SensorSubscriber(ConfiguredNode[SubscriberParameters]):
    """Subscribes to ``input``, drops what cannot be used, and publishes the rest as ``output``."""

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
        self._timeline = Timeline(self._guard)
        sources = Sources(self, node_time)
        self._input = SensorInput(
            sources, node_time, "input", self.parameters.input, self._guard, self._on_sample
        )
        self._output = RecordingPublisher(self, "output", POINT, self.recorder)
        self._point = functools.lru_cache(functools.partial(point_template, InstalledTypes()))
        self._report = SensorReport("input", self._input, self, self.log)
        self._diagnostics = Diagnostics(self, node_time, self._reports)

    def _on_sample(self, sample: Sample, now_ns: int, log_ns: int) -> None:
        tolerance = self.parameters.future_tolerance
        admission = self._timeline.receive(self._guard, sample, now_ns, tolerance)
        if admission.restarted:
            self.log.warning(
                "timestamps jumped back: passing on the new ones",
                throttle_duration_sec=RESTARTS_SAID_EVERY,
            )
        for _, each in admission.admitted:
            self._input.admitted()
            point = self._point(self._input.codec.frame(each.message))
            self._output.send(point.filled(each.value, each.stamp_ns), log_ns)

    def _reports(self) -> list[Report]:
        return [self._report.report(self._guard.timeout(self.parameters.input.timeout))]
