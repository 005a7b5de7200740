# SPDX-License-Identifier: Apache-2.0
"""What is said about the rules and the gate: which lead, and which are never of use."""

from __future__ import annotations

from collections.abc import Iterator

from fuzzy_fusion_ros.core.aggregator import FiringStrengths
from fuzzy_fusion_ros.nodes.rule_record import SATURATED, RuleRecord
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.ros.diagnostics import Level, Report, Summary

ENOUGH = 300
"""Estimates, or predictions, needed before anything counts as never or always."""

HARDLY = 0.1
"""A grade below which a set has not been of use."""

LONG = 10.0
"""Seconds of fully large difference after which the disagreement is reported."""


class RuleReport:
    """Reports how the membership functions and the gate are used.

    WARN where, over at least ``ENOUGH`` estimates, a membership function is never or always
    saturated or the gate never or always accepts; and where the sensors disagree for long. Where
    S1's bias is learnt, a difference that is never large is how it should be.
    """

    def __init__(self) -> None:
        self.record = RuleRecord()

    def restart(self) -> None:
        """Start a new record."""
        self.record = RuleRecord()

    def reports(self, parameters: Parameters) -> Iterator[Report]:
        """Report which rules led and what looks wrong.

        Args:
            parameters: Those in use.
        """
        record = self.record
        shares = [seconds / (record.watched_s or 1.0) for seconds in record.seconds]
        values: dict[str, object] = {
            f"share of time: difference {d}, rate {r}": share
            for share, (d, r) in zip(
                shares, (name.split("_") for name in FiringStrengths._fields), strict=True
            )
        }
        values["difference: lowest grade of large"] = record.difference[0]
        values["difference: highest grade of large"] = record.difference[1]
        values["rate: lowest grade of large"] = record.rate[0]
        values["rate: highest grade of large"] = record.rate[1]
        values["difference fully large for (s)"] = record.apart_s
        yield Report("rules", [*self._apart(parameters), *self._unused(parameters)], values)
        yield Report("gate", [*self._gate()], self._gate_values(parameters))

    def _apart(self, parameters: Parameters) -> Iterator[Summary]:
        if self.record.apart_s > LONG:
            limit = parameters.aggregator.difference.large
            yield Summary(
                Level.WARN,
                f"s1 and s2 have differed by {limit:g} or more for {self.record.apart_s:.1f} s: "
                "is one of them broken, or biased?",
            )

    def _unused(self, parameters: Parameters) -> Iterator[Summary]:
        guards_only = parameters.s1.bias_time_constant > 0.0  # large: S1 has gone wrong
        if self.record.estimates < ENOUGH:
            return
        for name, (lowest, highest) in {
            "difference": self.record.difference,
            "rate": self.record.rate,
        }.items():
            ramp = f"aggregator.{name}"
            if highest < HARDLY and not (guards_only and name == "difference"):
                yield Summary(Level.WARN, f"{name} is never large: lower {ramp}.large, or tune")
            if lowest >= SATURATED:
                yield Summary(Level.WARN, f"{name} is always large: raise {ramp}.large, or tune")

    def _gate(self) -> Iterator[Summary]:
        record = self.record
        if record.predictions < ENOUGH:
            return
        if record.accepted == 0:
            yield Summary(
                Level.WARN, "the gate rejects every prediction: raise gate.tolerance, or tune"
            )
        if record.accepted == record.predictions:
            yield Summary(
                Level.WARN, "the gate accepts every prediction: lower gate.tolerance, or tune"
            )

    def _gate_values(self, parameters: Parameters) -> dict[str, object]:
        record = self.record
        return {
            "predictor enabled": parameters.predictor.enabled,
            "predictions": record.predictions,
            "accepted": record.accepted,
            "acceptance rate": record.accepted / (record.predictions or 1),
        }
