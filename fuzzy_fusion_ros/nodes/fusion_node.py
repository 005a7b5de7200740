# SPDX-License-Identifier: Apache-2.0
"""The fusion as a node: two sensors in, the estimate and its explanation out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from std_srvs.srv import SetBool, Trigger

from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.fusion_report import FusionReport
from fuzzy_fusion_ros.nodes.modes import Mode
from fuzzy_fusion_ros.nodes.rule_report import RuleReport
from fuzzy_fusion_ros.nodes.self_check import SelfCheck
from fuzzy_fusion_ros.nodes.sensor_input import SensorInput
from fuzzy_fusion_ros.nodes.sensor_report import SensorReport
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Verdict
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.file import ParameterFileError, dump
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Diagnostics, Report
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.recorder import NoRecorder, recorder_for
from fuzzy_fusion_ros.self_tuning.choice import MEASURED

if TYPE_CHECKING:
    from fuzzy_fusion_ros.ros.lifecycle import Lifecycle


class FusionNode(ConfiguredNode[Parameters]):
    """Fuses ``s1`` and ``s2`` into ``estimate``."""

    _lifecycle: Lifecycle | None = None

    def __init__(self, **options: Any) -> None:
        """Make the node; ``options`` as :class:`ConfiguredNode` takes them.

        Raises:
            FusionError: A parameter, a message type or a field cannot be used.
        """
        super().__init__("fusion_node", Parameters(), **options)

    def destroy_node(self) -> None:
        """Leave the graph."""
        super().destroy_node()
        if self._lifecycle is not None:
            self._lifecycle.close()

    def set_up(self) -> None:
        """Create all that there is, or wait to be configured."""
        self._time = NodeTime(self)
        self._connected = False
        if self.parameters.lifecycle:
            from fuzzy_fusion_ros.ros.lifecycle import Lifecycle  # few nodes need it

            self._lifecycle = Lifecycle(self, self)
        else:
            self.connect()

    def connect(self) -> None:
        """Create topics, services and timers; estimates are published unless it is managed.

        Raises:
            FusionError: A parameter, a message type, a field or a bag cannot be used.
        """
        parameters = self.parameters
        if problem := parameters.aggregator.weight.order_problem():
            self.log.warning(problem)
        self.recorder = recorder_for(parameters.record)
        self._fusion = Fusion(parameters)
        guards = self._fusion.s1, self._fusion.s2
        self._s1 = SensorInput(self, self._time, "s1", parameters.s1, guards[0], self._on_s1)
        self._s2 = SensorInput(self, self._time, "s2", parameters.s2, guards[1], self._on_s2)
        unit = signal_unit(self._s1.codec, self._s2.codec, parameters)
        self._output = EstimateOutput(parameters.estimate, self._s2.codec, unit)
        self._rules = RuleReport()
        self._report = FusionReport(self.log)
        self._check = SelfCheck(self.log, self._s1, self._s2, parameters)
        self._s1_report = SensorReport("s1", self._s1, self)
        self._s2_report = SensorReport("s2", self._s2, self)
        self._diagnostics = Diagnostics(self, self._time, self._reports)
        self._jumps = self._time.on_jump_back(self._on_jump_back)
        self.create_service(Trigger, "~/reset", self._on_reset)
        self.create_service(SetBool, "~/enable", self._on_enable)
        self.create_service(Trigger, "~/save_parameters", self._on_save_parameters)
        if parameters.trigger == "timer":
            self._ticks = self._time.every(1.0 / parameters.rate, self.guarded(self._on_tick))
        self._connected = True
        if parameters.lifecycle:
            self._open()
            self.activate(False)

    def disconnect(self) -> None:
        """Finish the bag and forget the clock; the node's entities are destroyed elsewhere."""
        if self._connected:
            self._jumps.unregister()
        self._connected = False
        self.recorder.close()
        self.recorder = NoRecorder()

    def activate(self, active: bool) -> None:
        """Publish estimates from now on, or only process samples."""
        self._report.enable(active, Mode.INACTIVE)

    def on_spinning(self) -> None:
        """Publish from now on, unless managed."""
        if not self.parameters.lifecycle:
            self._open()
            self._report.start()

    def _open(self) -> None:
        """Create the topics of the estimate, and say what is fused into it."""
        self._output.open(self, self.recorder)
        self.log.info(
            f"s1: {self._s1.described()}; s2: {self._s2.described()}; "
            f"estimate: {self._output.described()}; trigger: {self.parameters.trigger}"
        )

    def _on_s1(self, data: bytes) -> None:
        received = self._s1.receive(data)
        if received is not None:
            self._check.s1.add(received.sample.stamp_ns, received.now_ns, received.sample.value)
            verdict = self._fusion.on_s1(received.sample, received.now_ns)
            if verdict.admitted:
                self._s1.admitted()
            self._publish(verdict, received.log_ns)

    def _on_s2(self, data: bytes) -> None:
        received = self._s2.receive(data)
        if received is not None:
            self._check.s2.add(received.sample.stamp_ns, received.now_ns, received.sample.value)
            verdict = self._fusion.on_s2(received.sample, received.now_ns)
            if verdict.admitted:
                self._s2.admitted()
            self._publish(verdict, received.log_ns)

    def _on_tick(self) -> None:
        self._publish(self._fusion.on_tick(), self._time.now_ns())

    def _publish(self, verdict: Verdict, log_ns: int) -> None:
        if verdict.restarted:
            self._check.restart()
            self.log.warning("timestamps jumped back: state cleared, restarting")
        for fused in verdict.estimates:
            self._rules.record.see(fused)
            self._report.see(fused)
            if self._report.enabled:
                self._output.publish(fused, self._fusion.parameters, log_ns)

    def _reports(self) -> list[Report]:
        parameters = self.parameters
        s1, s2 = self._s1, self._s2
        s1_timeout = s1.guard.timeout(parameters.s1.timeout)
        s2_timeout = s2.guard.timeout(parameters.s2.timeout)
        stale = s1.age > s1_timeout and s2.age > s2_timeout
        work = s1.subscription.work.drain() + s2.subscription.work.drain()
        held = [f"{name} = {value}" for name, value in self.held.items()]
        return [
            self._report.report(stale, self._output, self._fusion, work, self._time, held),
            self._s1_report.report(s1_timeout),
            self._s2_report.report(s2_timeout),
            *self._rules.reports(self._fusion.in_use),
            *self._self_tuning(),
            self._check.report(),
        ]

    def _self_tuning(self) -> Iterator[Report]:
        """Report the parameters that are measured, if they are."""
        if self.parameters.self_tuning:
            values = flatten(self._fusion.in_use)
            yield Report("self-tuning", [], {name: values[name] for name in MEASURED})

    def _on_jump_back(self, back_ns: int) -> None:
        """Clear what is from before the jump, unless samples have shown it already.

        Samples of the new time may come before the clock does, so those nearer to the time
        jumped to than to the time left count as new.
        """
        newest_ns = max(self._fusion.s1.newest_ns or 0, self._fusion.s2.newest_ns or 0)
        if newest_ns > self._time.now_ns() + back_ns // 2:
            self._publish(self._fusion.restart(), self._time.now_ns())

    def _on_reset(self, _: Trigger.Request, response: Any) -> Any:
        self._fusion.reset()
        self._rules.restart()
        response.success, response.message = True, "state cleared"
        return response

    def _on_save_parameters(self, _: Trigger.Request, response: Any) -> Any:
        """Write the parameters in use, as given from then on, to a new file."""
        path = Path(f"{self.get_name()}_saved.yaml").resolve()
        try:
            if path.exists():
                raise ParameterFileError(path, "exists: move it away, then save again")
            dump(replace(self._fusion.in_use, {"self_tuning": False}), path)
        except FusionError as error:
            response.success, response.message = False, str(error)
        else:
            response.success, response.message = True, f"parameters written to {path}"
        return response

    def _on_enable(self, request: Any, response: Any) -> Any:
        if self._report.mode is Mode.INACTIVE:
            response.success, response.message = False, "the node is inactive: activate it"
            return response
        self._report.enable(request.data)
        word = "enabled" if request.data else "disabled; samples are still processed"
        response.success, response.message = True, f"publishing is {word}"
        return response

    def on_parameters(self) -> None:
        """Use new parameters from the next sample on, and judge the rules afresh."""
        if not self._connected:
            return
        self._fusion.parameters = self.parameters
        self._rules.restart()
        period_ns = int(1e9 / self.parameters.rate)
        if self.parameters.trigger == "timer" and self._ticks.timer_period_ns != period_ns:
            self._ticks.timer_period_ns = period_ns
            self._ticks.reset()
