"""The mode of the fusion, watched and reported."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from rclpy.impl.rcutils_logger import RcutilsLogger

from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.modes import OF_ESTIMATE, Mode
from fuzzy_fusion_ros.online.fusion import Fused, Fusion
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary
from fuzzy_fusion_ros.ros.statistics import Rate, WorkTime
from fuzzy_fusion_ros.ros.subscription import SensorInput


class FusionReport:
    """Keeps the mode, logs its changes once, and reports it with the node's numbers.

    Attributes:
        mode: The mode.
        enabled: Whether estimates are published.
    """

    def __init__(
        self,
        log: RcutilsLogger,
        fusion: Fusion,
        sensors: tuple[SensorInput, SensorInput],
        output: EstimateOutput,
        work: WorkTime,
        parameters: Callable[[], Parameters],
    ) -> None:
        """Watch a fusion.

        Args:
            log: Where changes are said.
            fusion: The fusion.
            sensors: S1 and S2.
            output: What it publishes.
            work: How long callbacks take.
            parameters: Tells those that hold.
        """
        self.mode = Mode.WAITING
        self.enabled = True
        self._log = log
        self._fusion = fusion
        self._sensors = sensors
        self._output = output
        self._work = work
        self._parameters = parameters
        self._rate = Rate()
        self._unwritable = 0

    def see(self, fused: Fused) -> None:
        """Take an estimate: it shows the mode."""
        self._change(OF_ESTIMATE[fused.estimate.mode])

    def enable(self, enabled: bool) -> None:
        """Take note that estimates are published from now on, or not."""
        if enabled != self.enabled:
            self.enabled = enabled
            self._change(Mode.WAITING if enabled else Mode.DISABLED)

    def __call__(self) -> Iterator[Report]:
        """Say the mode, after a look at how long both sensors have been silent."""
        parameters = self._parameters()
        s1, s2 = self._sensors
        if s1.age > parameters.s1.timeout and s2.age > parameters.s2.timeout:
            self._change(Mode.STALE)
        summaries = [Summary(self.mode.level, f"{self.mode.name}: {self.mode.value}")]
        if self._output.unwritable > self._unwritable:
            summaries.append(
                Summary(Level.ERROR, f"estimates not published: {self._output.last_problem}")
            )
        self._unwritable = self._output.unwritable
        median, longest = self._work.take()
        yield Report(
            "fusion",
            summaries,
            {
                "mode": self.mode.name,
                "estimates": self._output.published,
                "estimate rate (Hz)": self._rate.of(self._output.published),
                "estimates not published": self._output.unwritable,
                "restarts after time jumped back": self._fusion.restarts,
                "processing time, median (ms)": median * 1e3,
                "processing time, maximum (ms)": longest * 1e3,
            },
        )

    def _change(self, mode: Mode) -> None:
        if not self.enabled:
            mode = Mode.DISABLED
        if mode is self.mode:
            return
        self.mode = mode
        text = f"{mode.name}: {mode.value}"
        if mode.level is Level.OK:
            self._log.info(text)
        elif mode.level is Level.WARN:
            self._log.warning(text)
        else:
            self._log.error(text)
