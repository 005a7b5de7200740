"""The fusion as a node: two sensors in, the estimate and its explanation out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from std_srvs.srv import SetBool, Trigger

from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.fusion_report import FusionReport
from fuzzy_fusion_ros.nodes.rule_report import RuleReport
from fuzzy_fusion_ros.nodes.sensor_report import SensorReport
from fuzzy_fusion_ros.online.fusion import Fused, Fusion
from fuzzy_fusion_ros.online.guard import Guard
from fuzzy_fusion_ros.parameters.fusion import Parameters, SensorParameters
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Diagnostics
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.qos import input_profile
from fuzzy_fusion_ros.ros.recorder import recorder_for
from fuzzy_fusion_ros.ros.statistics import WorkTime
from fuzzy_fusion_ros.ros.subscription import Received, SensorInput


class FusionNode(ConfiguredNode[Parameters]):
    """Fuses ``s1`` and ``s2`` into ``estimate``."""

    def __init__(self, **options: Any) -> None:
        """Make the node; ``options`` as :class:`ConfiguredNode` takes them.

        Raises:
            FusionError: A parameter, a message type or a field cannot be used.
        """
        super().__init__("fusion_node", Parameters(), **options)

    def set_up(self) -> None:
        """Create topics, services and timers."""
        parameters = self.parameters
        self._time = NodeTime(self)
        self.recorder = recorder_for(parameters.record)
        self._fusion = Fusion(parameters)
        work = WorkTime()
        s1, s2 = self._fusion.s1, self._fusion.s2
        self._s1 = self._input("s1", parameters.s1, s1, work.timed(self._on_s1))
        self._s2 = self._input("s2", parameters.s2, s2, work.timed(self._on_s2))
        self._output = EstimateOutput(parameters.estimate, self._s2)
        self._rules = RuleReport(lambda: self.parameters)
        self._report = FusionReport(
            self.log,
            self._fusion,
            (self._s1, self._s2),
            self._output,
            work,
            lambda: self.parameters,
        )
        self._diagnostics = Diagnostics(
            self,
            self._time,
            self._report,
            SensorReport("s1", self._s1, s1, lambda: self.parameters.s1.timeout),
            SensorReport("s2", self._s2, s2, lambda: self.parameters.s2.timeout),
            self._rules,
        )
        self._jumps = self._time.on_jump_back(self._on_jump_back)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(SetBool, "~/enable", self._on_enable)
        if parameters.trigger == "timer":
            self._ticks = self._time.every(1.0 / parameters.rate, self.guarded(self._on_tick))

    def _input(
        self,
        topic: str,
        parameters: SensorParameters,
        guard: Guard,
        take: Callable[[Received], bool],
    ) -> SensorInput:
        profile = input_profile(self.parameters.qos)
        return SensorInput(
            self,
            self._time,
            topic,
            parameters,
            profile,
            guard,
            self.recorder,
            take,
            lambda: self.parameters.future_tolerance,
        )

    def on_spinning(self) -> None:
        """Publish from now on."""
        self._output.open(self, self.recorder)

    def _on_s1(self, received: Received) -> bool:
        admitted, restarts = self._fusion.s1.admitted, self._fusion.restarts
        fused = self._fusion.take_s1(received.sample, received.now_ns)
        self._publish(fused, restarts, received.log_ns)
        return self._fusion.s1.admitted > admitted

    def _on_s2(self, received: Received) -> bool:
        admitted, restarts = self._fusion.s2.admitted, self._fusion.restarts
        fused = self._fusion.take_s2(received.sample, received.now_ns)
        if self._fusion.s2.admitted > admitted:
            self._output.see_s2(received.data)
        self._publish(fused, restarts, received.log_ns)
        return self._fusion.s2.admitted > admitted

    def _on_tick(self) -> None:
        self._publish(self._fusion.tick(), self._fusion.restarts, self._time.now_ns())

    def _publish(self, fused: Fused | None, restarts: int, log_ns: int) -> None:
        if self._fusion.restarts > restarts:
            self.log.warning("stamps have jumped back: history cleared, fusing anew")
        if fused is not None:
            self._rules.record.see(fused)
            self._report.see(fused)
            if self._report.enabled:
                self._output.publish(fused, log_ns)

    def _on_jump_back(self, back_ns: int) -> None:
        """Clear what is from before the jump; samples may have told already.

        Samples of the new time may come before the clock does, so those nearer to the time
        jumped to than to the time left count as new.
        """
        newest_ns = max(self._fusion.s1.newest_ns or 0, self._fusion.s2.newest_ns or 0)
        if newest_ns > self._time.now_ns() + back_ns // 2:
            self._fusion.reset()
            self.log.warning("the clock has jumped back: history cleared, fusing anew")

    def _on_reset(self, _: Trigger.Request, response: Any) -> Any:
        self._fusion.reset()
        self._rules.restart()
        response.success, response.message = True, "history cleared"
        return response

    def _on_enable(self, request: Any, response: Any) -> Any:
        self._report.enable(request.data)
        word = "published" if request.data else "taken in, no estimates are published"
        response.success, response.message = True, f"samples are {word}"
        return response

    def on_parameters(self) -> None:
        """Let the next sample see new parameters, and what is said of them start anew."""
        self._fusion.parameters = self.parameters
        self._rules.restart()
        period_ns = int(1e9 / self.parameters.rate)
        if self.parameters.trigger == "timer" and self._ticks.timer_period_ns != period_ns:
            self._ticks.timer_period_ns = period_ns
            self._ticks.reset()
