# SPDX-License-Identifier: Apache-2.0
"""The fusion as a node: two sensors in, the estimate and its explanation out."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

from std_srvs.srv import SetBool, Trigger

from fuzzy_fusion_ros.nodes.channel import Channel
from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.modes import Mode
from fuzzy_fusion_ros.nodes.source import Sources
from fuzzy_fusion_ros.online.joint import Joint
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.parameters.file import ParameterFileError, dump
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Diagnostics, Report
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.recorder import NoRecorder, recorder_for

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
        self._background = ThreadPoolExecutor(1)  # one: all wait for the same interpreter
        super().__init__("fusion_node", Parameters(), **options)

    def destroy_node(self) -> None:
        """Leave the graph; what runs in the background ends before the process does."""
        super().destroy_node()
        self._background.shutdown(wait=False, cancel_futures=True)
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
        self.recorder = recorder_for(parameters.record)
        self._enabled = True
        self._by_channel = parameters.by_channel()
        self._joint = Joint()
        self._sources = Sources(self, self._time, self._publish)
        self.channels = tuple(
            Channel(self, self._time, name, own, self._sources, self._joint, self._background)
            for name, own in self._by_channel.items()
        )
        self._output = EstimateOutput(
            {each.name: each.source for each in self.channels},
            {each.name: each.unit for each in self.channels},
        )
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
        self._enable(active, Mode.INACTIVE)

    def _enable(self, enabled: bool, silent: Mode) -> None:
        self._enabled = enabled
        for each in self.channels:
            each.report.enable(enabled, silent)

    def on_spinning(self) -> None:
        """Publish from now on, unless managed."""
        if not self.parameters.lifecycle:
            self._open()
            for each in self.channels:
                each.report.start()

    def _open(self) -> None:
        """Create the topics of the estimate, and say what is fused into it."""
        self._output.open(self, self.recorder)
        for each in self.channels:
            named = f"{each.name}: " if each.name else ""
            self.log.info(
                f"{named}s1: {each.s1.described()}; s2: {each.s2.described()}; "
                f"estimate: {self._output.described()}; trigger: {self.parameters.trigger}"
            )

    def _on_tick(self) -> None:
        for each in self.channels:
            each.on_tick()
        self._publish(self._time.now_ns())

    def _publish(self, log_ns: int) -> None:
        """Publish what a message or a tick has brought about."""
        for together in self._joint.due():
            if self._enabled:
                self._output.publish(together, self._by_channel, log_ns)

    def _reports(self) -> list[Report]:
        work = self._sources.work()
        return [
            report
            for each in self.channels
            for report in each.reports(self._output, work, self.held)
        ]

    def _on_jump_back(self, back_ns: int) -> None:
        """Clear what is from before the jump, unless samples have shown it already.

        Samples of the new time may come before the clock does, so those nearer to the time
        jumped to than to the time left count as new.
        """
        for each in self.channels:
            each.restart(self._time.now_ns() + back_ns // 2)
        self._publish(self._time.now_ns())

    def _on_reset(self, _: Trigger.Request, response: Any) -> Any:
        for each in self.channels:
            each.reset()
        self._joint.reset()
        response.success, response.message = True, "state cleared"
        return response

    def _on_save_parameters(self, _: Trigger.Request, response: Any) -> Any:
        """Write the parameters in use, as given from then on, to a new file."""
        path = Path(f"{self.get_name()}_saved.yaml").resolve()
        try:
            if path.exists():
                raise ParameterFileError(path, "exists: move it away, then save again")
            in_use = self.parameters
            for each in self.channels:
                in_use = in_use.with_channel(each.name, each.fusion.in_use)
            dump(replace(in_use, {"self_tuning": False}), path)
        except FusionError as error:
            response.success, response.message = False, str(error)
        else:
            response.success, response.message = True, f"parameters written to {path}"
        return response

    def _on_enable(self, request: Any, response: Any) -> Any:
        if any(each.report.mode is Mode.INACTIVE for each in self.channels):
            response.success, response.message = False, "the node is inactive: activate it"
            return response
        self._enable(request.data, Mode.DISABLED)
        word = "enabled" if request.data else "disabled; samples are still processed"
        response.success, response.message = True, f"publishing is {word}"
        return response

    def on_parameters(self) -> None:
        """Use new parameters from the next sample on, and judge the rules afresh."""
        if not self._connected:
            return
        self._by_channel = self.parameters.by_channel()
        for each in self.channels:
            each.use(self._by_channel[each.name])
        period_ns = int(1e9 / self.parameters.rate)
        if self.parameters.trigger == "timer" and self._ticks.timer_period_ns != period_ns:
            self._ticks.timer_period_ns = period_ns
            self._ticks.reset()
