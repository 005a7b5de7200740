# SPDX-License-Identifier: Apache-2.0
"""Publishes estimates, and what stands behind them as far as someone listens."""

from __future__ import annotations

from rclpy.node import Node

from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.outputs import (
    EXPLANATION,
    SENTENCE,
    TEXT,
    EstimateMessages,
    explain,
    point_template,
    text_message,
)
from fuzzy_fusion_ros.online.explanation import explanation
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.parameters.errors import MessageError
from fuzzy_fusion_ros.parameters.fusion import EstimateParameters, Parameters
from fuzzy_fusion_ros.ros.publisher import RecordingPublisher
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.ros.recorder import NoRecorder, Recorder


class EstimateOutput:
    """The topics ``estimate`` and ``~/weight``, ``~/drift`` and so on.

    Attributes:
        published: Estimates published.
        unwritable: Estimates that did not fit into a message.
        last_problem: Why the last of them did not; empty if all did.
    """

    def __init__(self, parameters: EstimateParameters, s2: ScalarCodec, unit: str) -> None:
        """Settle type and field.

        Args:
            parameters: Type and field where they are not S2's.
            s2: Reads S2.
            unit: Unit of the signal, ``""`` where it is not known.

        Raises:
            MessageError: The type of the estimate is not installed or has no such field.
        """
        self._messages = EstimateMessages(InstalledTypes(), parameters, s2)
        self._point = point_template(InstalledTypes())
        self._unit = unit
        self._estimate: RecordingPublisher | None = None
        self._explanation: dict[str, RecordingPublisher] = {}
        self._sentence: RecordingPublisher | None = None
        self.published = 0
        self.unwritable = 0
        self.last_problem = ""

    def open(self, node: Node, recorder: Recorder) -> None:
        """Begin to publish: whoever waits for the estimate's publisher may then send samples."""
        self._explanation = {
            name: RecordingPublisher(node, f"~/{name}", type_name, recorder)
            for name, type_name in EXPLANATION.items()
        }
        self._sentence = RecordingPublisher(node, f"~/{SENTENCE}", TEXT, NoRecorder())
        self._estimate = RecordingPublisher(
            node, "estimate", self._messages.codec.type_name, recorder, ESTIMATE
        )

    def described(self) -> str:
        """Return topic, field and type in words, once the topic is open."""
        topic = self._estimate.topic if self._estimate is not None else "estimate"
        codec = self._messages.codec
        return f"{topic}, {codec.field.text} of {codec.type_name}"

    @property
    def wanted(self) -> dict[str, RecordingPublisher]:
        """The topics of the explanation that someone listens to, by name."""
        return {
            name: publisher for name, publisher in self._explanation.items() if publisher.wanted
        }

    def publish(self, fused: Fused, parameters: Parameters, log_ns: int) -> None:
        """Publish an estimate, then what explains it and is asked for.

        Args:
            fused: The estimate.
            parameters: Those that it was made with.
            log_ns: Time of what brought it about, nanoseconds.
        """
        if self._estimate is None:
            return
        try:
            data = self._messages.message(fused)
        except MessageError as error:
            self.unwritable += 1
            self.last_problem = str(error)
            return
        self._estimate.send(data, log_ns)
        self.published += 1
        wanted = self.wanted
        if wanted:
            for name, data in explain(self._point, fused):
                if name in wanted:
                    wanted[name].send(data, log_ns)
        if self._sentence is not None and self._sentence.wanted:
            self._sentence.send(text_message(explanation(parameters, fused, self._unit)), log_ns)
