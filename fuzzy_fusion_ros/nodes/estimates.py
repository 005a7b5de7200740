# SPDX-License-Identifier: Apache-2.0
"""Publishes estimates, and what stands behind them as far as someone listens."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

from rclpy.node import Node

from fuzzy_fusion_ros.messages import InstalledTypes
from fuzzy_fusion_ros.messages.codec import Template
from fuzzy_fusion_ros.messages.outputs import (
    EXPLANATION,
    SENTENCE,
    TEXT,
    EstimateMessages,
    EstimateSource,
    explain,
    point_template,
    text_message,
)
from fuzzy_fusion_ros.online.explanation import explanation
from fuzzy_fusion_ros.online.verdict import Fused, Together
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.ros.recorder import NoRecorder, Recorder


class EstimateOutput:
    """The topics ``estimate`` and, of each channel, ``~/weight``, ``~/drift`` and so on.

    Attributes:
        published: Estimates published.
        unwritable: Estimates that did not fit into a message.
        last_problem: Why the last of them did not; empty if all did.
    """

    def __init__(self, sources: Mapping[str, EstimateSource], units: Mapping[str, str]) -> None:
        """Settle type and fields.

        Args:
            sources: What the estimates are made from, by channel.
            units: Units of the signals, ``""`` where they are not known.

        Raises:
            MessageError: The type of the estimate is not installed or has no such field, or
                channels do not fit into one message.
        """
        self._messages = EstimateMessages(InstalledTypes(), sources)
        self._point = point_template(InstalledTypes())
        self._units = units
        self._estimate: RecordingPublisher | None = None
        self._explanations: dict[str, _Explanation] = {}
        self.published = 0
        self.unwritable = 0
        self.last_problem = ""

    def open(self, node: Node, recorder: Recorder) -> None:
        """Begin to publish: whoever waits for the estimate's publisher may then send samples."""
        self._explanations = {
            channel: _Explanation(node, channel, unit, recorder)
            for channel, unit in self._units.items()
        }
        self._estimate = RecordingPublisher(
            node, "estimate", self._messages.type_name, recorder, ESTIMATE
        )

    @property
    def lacking(self) -> Counter[str]:
        """Messages made without the estimate of a channel, by its name."""
        return self._messages.lacking

    def described(self) -> str:
        """Return topic, fields and type in words, once the topic is open."""
        topic = self._estimate.topic if self._estimate is not None else "estimate"
        return f"{topic}, {self._messages.described}"

    @property
    def wanted(self) -> dict[str, RecordingPublisher]:
        """The topics of the explanation that someone listens to, by name."""
        return {
            f"{channel}/{name}" if channel else name: publisher
            for channel, each in self._explanations.items()
            for name, publisher in each.wanted.items()
        }

    def publish(
        self, together: Together, parameters: Mapping[str, Parameters], log_ns: int
    ) -> None:
        """Publish the estimates of a stamp, then what explains them and is asked for.

        Args:
            together: The estimates.
            parameters: Those that they were made with, by channel.
            log_ns: Time of what brought them about, nanoseconds.
        """
        if self._estimate is None:
            return
        try:
            data = self._messages.message(together)
        except MessageError as error:
            self.unwritable += 1
            self.last_problem = str(error)
            return
        self._estimate.send(data, log_ns)
        self.published += 1
        for channel, fused in together.fused.items():
            self._explanations[channel].publish(self._point, fused, parameters[channel], log_ns)


class _Explanation:
    """The topics that explain the estimates of a channel."""

    def __init__(self, node: Node, channel: str, unit: str, recorder: Recorder) -> None:
        prefix = f"~/{channel}/" if channel else "~/"
        self._unit = unit
        self._wanted: set[str] = set()
        self._publishers = {
            name: RecordingPublisher(node, prefix + name, kind, recorder, wanted=self._wanted)
            for name, kind in EXPLANATION.items()
        }
        self.sentence = RecordingPublisher(
            node, prefix + SENTENCE, TEXT, NoRecorder(), wanted=self._wanted
        )

    @property
    def wanted(self) -> dict[str, RecordingPublisher]:
        return {name: each for name, each in self._publishers.items() if each.wanted}

    def publish(self, point: Template, fused: Fused, parameters: Parameters, log_ns: int) -> None:
        if not self._wanted:  # as a rule
            return
        wanted = self.wanted
        if wanted:
            for name, data in explain(point, fused):
                if name in wanted:
                    wanted[name].send(data, log_ns)
        if self.sentence.wanted:
            text = explanation(parameters, fused, self._unit)
            self.sentence.send(text_message(text), log_ns)
