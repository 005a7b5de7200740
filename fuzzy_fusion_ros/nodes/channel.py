# SPDX-License-Identifier: Apache-2.0
"""One scalar of the node: two sensors fused, watched and reported."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from typing import Any

from fuzzy_fusion_ros.core.sample import Sample
from fuzzy_fusion_ros.messages.outputs import EstimateSource
from fuzzy_fusion_ros.messages.units import signal_unit
from fuzzy_fusion_ros.nodes.estimates import EstimateOutput
from fuzzy_fusion_ros.nodes.fusion_report import FusionReport
from fuzzy_fusion_ros.nodes.rule_report import RuleReport
from fuzzy_fusion_ros.nodes.self_check import SelfCheck
from fuzzy_fusion_ros.nodes.sensor_input import RESTARTS_SAID_EVERY, SensorInput
from fuzzy_fusion_ros.nodes.sensor_report import SensorReport
from fuzzy_fusion_ros.nodes.source import Sources
from fuzzy_fusion_ros.online.fusion import Fusion
from fuzzy_fusion_ros.online.joint import Joint
from fuzzy_fusion_ros.online.verdict import Verdict
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten
from fuzzy_fusion_ros.ros.clock import NodeTime
from fuzzy_fusion_ros.ros.diagnostics import Report
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.self_tuning.choice import MEASURED


class Channel:
    """Fuses one scalar of the messages on ``s1`` and ``s2``.

    Attributes:
        name: Its name, ``""`` if the node has no others.
        fusion: Fuses.
        s1, s2: Its sensors.
        source: What its estimates are made from.
        unit: Unit of the signal, ``""`` where it is not known.
        report: The mode.
    """

    def __init__(
        self,
        node: ConfiguredNode[Parameters],
        node_time: NodeTime,
        name: str,
        parameters: Parameters,
        sources: Sources,
        joint: Joint,
        background: Executor,
    ) -> None:
        """Subscribe to both sensors.

        Args:
            node: The node.
            node_time: Its clocks.
            name: Its name.
            parameters: Its parameters, as if it were alone.
            sources: What the node reads.
            joint: Where its estimates go.
            background: Runs what takes too long for a callback.

        Raises:
            MessageError: A type is not installed or has no such field, or units do not go together.
        """
        self.name = name
        self._log = node.log.get_child(name) if name else node.log
        if problem := parameters.aggregator.weight.order_problem():
            self._log.warning(problem)
        self.fusion = Fusion(parameters)
        self._time = node_time
        self._joint = joint
        joint.add(name, self.fusion)
        s1, s2 = self.fusion.s1, self.fusion.s2
        self.s1 = SensorInput(sources, node_time, "s1", parameters.s1, s1, self._on_s1)
        self.s2 = SensorInput(sources, node_time, "s2", parameters.s2, s2, self._on_s2)
        self.source = EstimateSource(parameters.estimate, self.s2.codec)
        self.unit = signal_unit(self.s1.codec, self.s2.codec, parameters)
        self._rules = RuleReport()
        self.report = FusionReport(self._log)
        self._check = SelfCheck(self._log, self.s1, self.s2, parameters, background)
        self._s1_report = SensorReport("s1", self.s1, node, self._log)
        self._s2_report = SensorReport("s2", self.s2, node, self._log)

    def _on_s1(self, sample: Sample, now_ns: int, _: int) -> None:
        self._check.s1.add(sample.stamp_ns, now_ns, sample.value)
        verdict = self.fusion.on_s1(sample, now_ns)
        if verdict.admitted:
            self.s1.admitted()
        self._follow(verdict)

    def _on_s2(self, sample: Sample, now_ns: int, _: int) -> None:
        self._check.s2.add(sample.stamp_ns, now_ns, sample.value)
        verdict = self.fusion.on_s2(sample, now_ns)
        if verdict.admitted:
            self.s2.admitted()
        self._follow(verdict)

    def on_tick(self) -> None:
        """Estimate, if it is the timer that makes estimates due."""
        self._follow(self.fusion.on_tick())

    def _follow(self, verdict: Verdict) -> None:
        if verdict.restarted:
            self._check.restart()
            self._log.warning(
                "timestamps jumped back: state cleared, restarting",
                throttle_duration_sec=RESTARTS_SAID_EVERY,
            )
        for fused in verdict.estimates:
            self._rules.record.see(fused)
            self.report.see(fused)
        self._joint.take(self.name, verdict.estimates)

    def restart(self, newer_than_ns: int) -> None:
        """Clear what is from before a jump of the clock, unless samples have shown it already.

        Args:
            newer_than_ns: Nothing is cleared if no stamp is above this.
        """
        newest_ns = max(self.fusion.s1.newest_ns or 0, self.fusion.s2.newest_ns or 0)
        if newest_ns > newer_than_ns:
            self._follow(self.fusion.restart())

    def reset(self) -> None:
        """Forget all samples."""
        self.fusion.reset()
        self._rules.restart()

    def use(self, parameters: Parameters) -> None:
        """Use new parameters from the next sample on, and judge the rules afresh."""
        self.fusion.parameters = parameters
        self._rules.restart()

    def reports(
        self, output: EstimateOutput, work: list[float], held: dict[str, Any]
    ) -> Iterator[Report]:
        """Yield what there is to report.

        Args:
            output: What has been published.
            work: How long each message of the node took since the last report, seconds.
            held: Parameters that wait for others, with their values.
        """
        parameters = self.fusion.parameters
        s1_timeout = self.s1.guard.timeout(parameters.s1.timeout)
        s2_timeout = self.s2.guard.timeout(parameters.s2.timeout)
        silent = self.s1.age > s1_timeout and self.s2.age > s2_timeout
        heard = self.s1.subscription.received + self.s2.subscription.received > 0
        waiting = [f"{name} = {value}" for name, value in held.items()]
        absent = output.lacking[self.name], self._joint.withheld[self.name]
        yield self._named(
            self.report.report(
                silent and heard, output, self.fusion, work, self._time, waiting, absent
            )
        )
        yield self._named(self._s1_report.report(s1_timeout))
        yield self._named(self._s2_report.report(s2_timeout))
        yield from map(self._named, self._rules.reports(self.fusion.in_use))
        if parameters.self_tuning:
            values = flatten(self.fusion.in_use)
            measured = {name: values[name] for name in MEASURED}
            yield self._named(Report("self-tuning", [], measured))
        yield from map(self._named, self._adaptation())
        yield self._named(self._check.report())

    def _adaptation(self) -> Iterator[Report]:
        """Report what is adapted, if anything is."""
        lag, scale = self.fusion.adaptation
        model = self.fusion.in_use.s2
        if lag.is_on or scale.is_on:
            values = {
                "S2's lag and delay, times": lag.value,
                "S2's lag (s)": lag.value * model.lag_time_constant,
                "S2's delay (s)": lag.value * model.delay,
                "S1's movements, times": scale.value,
            }
            yield Report("adaptation", [], values)

    def _named(self, report: Report) -> Report:
        return report._replace(part=f"{self.name}.{report.part}") if self.name else report
