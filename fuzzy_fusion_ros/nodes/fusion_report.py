# SPDX-License-Identifier: Apache-2.0
"""The mode of the fusion, watched and reported."""

from __future__ import annotations

from collections.abc import Iterator

from rclpy.impl.rcutils_logger import RcutilsLogger

from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.modes import OF_ESTIMATE, Mode
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.verdict import Fused
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary
from fuzzy_fusion_ros.ros.statistics import Rate, median_and_maximum


class FusionReport:
    """Keeps the mode, logs its changes once, and reports it with the node's numbers.

    Attributes:
        mode: The mode.
        enabled: Whether estimates are published.
    """

    def __init__(self, log: RcutilsLogger) -> None:
        self.mode = Mode.WAITING
        self.enabled = True
        self._silent = Mode.DISABLED
        self._log = log
        self._rate = Rate()
        self._unwritable = 0
        self._absent = 0, 0
        self._warned = False

    def start(self) -> None:
        """Log the mode that the node starts in."""
        self._log_mode()

    def see(self, fused: Fused) -> None:
        """Take an estimate: it shows the mode."""
        self._change(OF_ESTIMATE[fused.estimate.mode])

    def enable(self, enabled: bool, silent: Mode = Mode.DISABLED) -> None:
        """Take note that estimates are published from now on, or not.

        Args:
            enabled: Whether they are.
            silent: The mode while they are not.
        """
        self._silent = silent
        if enabled != self.enabled:
            self.enabled = enabled
            self._change(Mode.WAITING if enabled else silent)

    def report(
        self,
        stale: bool,
        output: EstimateOutput,
        fusion: Fusion,
        work: list[float],
        node_time: NodeTime,
        held: list[str],
        absent: tuple[int, int],
    ) -> Report:
        """Report the mode and the node's numbers.

        Args:
            stale: Whether both sensors have been silent past their timeouts, not counting the time
                before the first message of either.
            output: What has been published.
            fusion: The fusion.
            work: How long each message took since the last report, seconds.
            node_time: The clocks of the node.
            held: Parameters that wait for others, with their values.
            absent: How many estimates of other channels were published without this one, and how
                many were not published because this one was missing.
        """
        if stale:
            self._change(Mode.STALE)
        summaries = [Summary(self.mode.level, f"{self.mode.name}: {self.mode.value}")]
        if output.unwritable > self._unwritable:
            summaries.append(
                Summary(Level.ERROR, f"estimates not published: {output.last_problem}")
            )
        self._unwritable = output.unwritable
        if held:
            text = f"not in use until their partners are set as well: {', '.join(held)}"
            summaries.append(Summary(Level.WARN, text))
        summaries += self._absence(absent)
        summaries += self._clocks(fusion.clock_problem(), node_time)
        median, longest = median_and_maximum(work)
        return Report(
            "fusion",
            summaries,
            {
                "mode": self.mode.name,
                "estimates": output.published,
                "estimate rate (Hz)": self._rate.of(output.published),
                "estimates not published": output.unwritable,
                "restarts after timestamps jumped back": fusion.restarts,
                "processing time, median (ms)": median * 1e3,
                "processing time, maximum (ms)": longest * 1e3,
            },
        )

    def _absence(self, absent: tuple[int, int]) -> Iterator[Summary]:
        """Warn if other channels have gone on without this one since the last report."""
        new = [now - before for now, before in zip(absent, self._absent, strict=True)]
        self._absent = absent
        if new[0]:
            text = f"{new[0]} estimates published without this channel; its field is that of s2"
            yield Summary(Level.WARN, text)
        if new[1] and self.enabled:
            text = (
                f"{new[1]} estimates not published because this channel has none with their stamp"
            )
            yield Summary(Level.WARN, text)

    def _clocks(self, problem: str, node_time: NodeTime) -> list[Summary]:
        """Warn of clocks that stand or are apart, in the log once until they are in order."""
        if node_time.simulated and node_time.now_ns() == 0:
            problem = "use_sim_time is true, but nothing has been received on /clock"
        if problem and not self._warned:
            self._log.warning(problem)
        self._warned = bool(problem)
        return [Summary(Level.WARN, problem)] if problem else []

    def _change(self, mode: Mode) -> None:
        if not self.enabled:
            mode = self._silent
        if mode is self.mode:
            return
        self.mode = mode
        self._log_mode()

    def _log_mode(self) -> None:
        mode = self.mode
        text = f"{mode.name}: {mode.value}"
        if mode.level is Level.OK:
            self._log.info(text)
        elif mode.level is Level.WARN:
            self._log.warning(text)
        else:
            self._log.error(text)
