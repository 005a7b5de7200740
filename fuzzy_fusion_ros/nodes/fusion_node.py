"""The fusion as a node: two sensors in, the estimate and its explanation out."""

from __future__ import annotations

from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from fuzzy_fusion_ros.core.fusion import Fused, Fusion
from fuzzy_fusion_ros.core.parameters import Parameters, SensorParameters
from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.explanation import Explanation
from fuzzy_fusion_ros.nodes.parameters import ConfiguredNode
from fuzzy_fusion_ros.nodes.recorder import recorder_for
from fuzzy_fusion_ros.nodes.sensor_input import Received, SensorInput


class FusionNode(ConfiguredNode[Parameters]):
    """Fuses ``s1`` and ``s2`` into ``estimate``."""

    def __init__(self, **options: Any) -> None:
        """Set up topics, services and timers; ``options`` as :class:`rclpy.node.Node` takes them.

        Raises:
            FusionError: A parameter, a message type or a field cannot be used.
        """
        super().__init__("fusion_node", Parameters(), **options)
        self._recorder = recorder_for(self.parameters.record)
        self._fusion = Fusion(self.parameters)
        self._s1 = self._input("s1", self.parameters.s1, self._on_s1)
        self._s2 = self._input("s2", self.parameters.s2, self._on_s2)
        self._output = EstimateOutput(self, self.parameters.estimate, self._s2, self._recorder)
        self._explanation = Explanation(self, self._recorder)
        if self.parameters.trigger == "timer":
            period = 1.0 / self.parameters.rate
            steady = Clock(clock_type=ClockType.STEADY_TIME)
            self._ticks = self.create_timer(period, self.guarded(self._on_tick), clock=steady)

    def _input(self, topic: str, parameters: SensorParameters, take: Any) -> SensorInput:
        return SensorInput(
            self,
            topic,
            parameters,
            qos=self.parameters.qos,
            future_tolerance=self.parameters.future_tolerance,
            recorder=self._recorder,
            take=take,
        )

    def _on_s1(self, received: Received) -> None:
        self._publish(self._fusion.take_s1(received.sample, received.now_ns), received.log_ns)

    def _on_s2(self, received: Received) -> None:
        admitted = self._fusion.s2.admitted
        fused = self._fusion.take_s2(received.sample, received.now_ns)
        if self._fusion.s2.admitted > admitted:
            self._output.see_s2(received.message)
        self._publish(fused, received.log_ns)

    def _on_tick(self) -> None:
        self._publish(self._fusion.tick(), self.get_clock().now().nanoseconds)

    def _publish(self, fused: Fused | None, log_ns: int) -> None:
        if fused is not None and self._output.publish(fused, log_ns):
            self._explanation.publish(fused, log_ns)

    def on_parameters(self) -> None:
        """Let the next sample see new parameters."""
        self._fusion.parameters = self.parameters

    def destroy_node(self) -> None:
        """Finish the bag, then leave the graph."""
        self._recorder.close()
        super().destroy_node()
