# SPDX-License-Identifier: Apache-2.0
"""What is said on /diagnostics, and when it is a warning."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from nodes.watching import OK, WARN, Diagnostics

from fuzzy_fusion_ros.core.aggregator import Aggregate, FiringStrengths
from fuzzy_fusion_ros.core.estimator import FUSED, S1_ONLY, Estimate, initial_state
from fuzzy_fusion_ros.core.gate import Prediction
from fuzzy_fusion_ros.nodes.rule_report import ENOUGH, LONG, RuleReport
from fuzzy_fusion_ros.nodes.sensor_subscriber import SensorSubscriber
from fuzzy_fusion_ros.online.fusion import Fused
from fuzzy_fusion_ros.online.guard import Drop
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.ros.diagnostics import Level
from fuzzy_fusion_ros.testing import Harness

STEP_NS = 10_000_000


def fused(
    k: int, d: float, r: float, *, predicts: bool = False, accepts: bool = False, mode: int = FUSED
) -> Fused:
    """An estimate at which difference and rate are large to these grades."""
    strengths = FiringStrengths((1 - d) * (1 - r), (1 - d) * r, d * (1 - r), d * r)
    aggregate = Aggregate(value=0.0, weight=0.0, drift=0.0, strengths=strengths)
    prediction = Prediction(exists=predicts, value=0.0)
    estimate = Estimate(mode, 0.0, aggregate, prediction, accepts)
    return Fused(k * STEP_NS, estimate, initial_state(Parameters()))


def summaries(report: RuleReport, parameters: Parameters | None = None) -> dict[str, list[str]]:
    """The texts of a report by its parts; all are warnings."""
    reports = list(report.reports(parameters or Parameters()))
    assert {each.level for part in reports for each in part.summaries} <= {Level.WARN}
    return {part.part: [each.text for each in part.summaries] for part in reports}


def values(report: RuleReport, part: str) -> dict[str, object]:
    return next(dict(each.values) for each in report.reports(Parameters()) if each.part == part)


def test_shares_of_time_follow_the_stamps_not_the_count() -> None:
    report = RuleReport()
    for k, d, r in ((0, 0.1, 0.1), (3, 0.1, 0.9), (4, 0.9, 0.1), (8, 0.9, 0.9), (10, 0.0, 0.0)):
        report.record.see(fused(k, d, r))
    shares = values(report, "rules")
    assert [shares[f"share of time: difference {d}, rate {r}"] for d in SL for r in SL] == (
        pytest.approx([0.3, 0.1, 0.4, 0.2])
    )


SL = ("small", "large")


def test_a_gap_counts_for_little_and_a_single_sensor_for_nothing() -> None:
    report = RuleReport()
    for k, mode in ((0, FUSED), (100_000, FUSED), (100_001, S1_ONLY), (200_000, FUSED)):
        report.record.see(fused(k, 0.0, 0.0, mode=mode))
    assert report.record.watched_s == pytest.approx(1.0)
    assert report.record.estimates == 3


UNUSED = {
    "difference is never large": (0.05, 0.5),
    "difference is always large": (1.0, 0.5),
    "rate is never large": (0.5, 0.05),
    "rate is always large": (0.5, 1.0),
}


@pytest.mark.parametrize("text", UNUSED)
def test_a_membership_function_that_is_of_no_use_is_a_warning(text: str) -> None:
    report = RuleReport()
    for k in range(ENOUGH - 1):
        report.record.see(fused(k, *UNUSED[text]))
    assert summaries(report)["rules"] == []
    report.record.see(fused(ENOUGH, *UNUSED[text]))
    (found,) = summaries(report)["rules"]
    assert found.startswith(text)
    report.record.see(fused(ENOUGH + 1, 0.5, 0.5))
    assert summaries(report)["rules"] == []


def test_where_the_bias_is_learnt_a_difference_is_not_expected_to_be_large() -> None:
    report = RuleReport()
    for k in range(ENOUGH):
        report.record.see(fused(k, 0.0, 0.5))
    learning = replace(Parameters(), {"s1.bias_time_constant": 1.0})
    assert summaries(report, learning)["rules"] == []
    assert summaries(report)["rules"] != []


def test_the_gate_that_never_or_always_accepts_is_a_warning() -> None:
    report = RuleReport()
    for accepts, word in ((False, "rejects every prediction"), (True, "accepts every prediction")):
        report.restart()
        for k in range(ENOUGH - 1):
            report.record.see(fused(k, 0.5, 0.5, predicts=True, accepts=accepts))
        assert summaries(report)["gate"] == []
        report.record.see(fused(ENOUGH, 0.5, 0.5, predicts=True, accepts=accepts))
        (found,) = summaries(report)["gate"]
        assert word in found
        report.record.see(fused(ENOUGH + 1, 0.5, 0.5, predicts=True, accepts=not accepts))
        assert summaries(report)["gate"] == []
    assert values(report, "gate")["acceptance rate"] == pytest.approx(ENOUGH / (ENOUGH + 1))


def test_sensors_that_disagree_for_long_are_a_warning() -> None:
    report = RuleReport()
    parameters = replace(Parameters(), {"aggregator.difference.large": 2.5})
    long = round(LONG * 1e9) // STEP_NS
    for k in range(0, long + 1, 50):
        report.record.see(fused(k, 1.0, 0.5))
    assert summaries(report)["rules"] == []
    report.record.see(fused(long + 50, 1.0, 0.5))
    (found,) = summaries(report, parameters)["rules"]
    assert found.startswith("s1 and s2 have differed by 2.5 or more for 10.5 s")
    report.record.see(fused(long + 100, 0.9, 0.5))
    assert summaries(report)["rules"] == []


def test_a_healthy_node_says_so_with_its_numbers(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair", "predictor.enabled": True})
    feed = harness.feed()
    for k in range(100):
        feed(0.01 * k, s1=0.01 * k, s2=0.01 * k)
    fusion = diagnostics.having("fusion_node: fusion", "estimates", "100")
    assert fusion.level == OK
    assert "FUSED: both sensors" in fusion.message
    median, longest = (
        float(fusion.values[f"processing time, {which} (ms)"]) for which in ("median", "maximum")
    )
    assert 0.0 < median <= longest
    assert float(fusion.values["estimate rate (Hz)"]) > 0.0
    for sensor in ("s1", "s2"):
        status = diagnostics.having(f"fusion_node: {sensor}", "received", "100")
        assert (status.level, status.message) == (OK, "OK")
        assert status.values["admitted"] == "100"
        assert float(status.values["rate (Hz)"]) > 0.0
        assert float(status.values["age (s)"]) >= 0.0
        assert {status.values[f"dropped: {each.value}"] for each in Drop} == {"0"}
    assert not diagnostics.of("fusion_node: adaptation")
    rules = diagnostics.of("fusion_node: rules")[-1]
    shares = [float(share) for name, share in rules.values.items() if name.startswith("share")]
    assert sum(shares) == pytest.approx(1.0, abs=1e-4)
    gate = diagnostics.of("fusion_node: gate")[-1]
    assert gate.values["predictor enabled"] == "True"
    assert int(gate.values["predictions"]) > 0


def test_unused_membership_functions_are_said_by_the_node(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    for k in range(ENOUGH):
        feed(0.01 * k, s1=0.0, s2=0.0)
    status = diagnostics.saying("fusion_node: rules", "difference is never large")
    assert status.level == WARN
    assert "rate is never large: lower aggregator.rate.large, or tune" in status.message


def test_every_part_and_value_is_documented(harness: Harness, diagnostics: Diagnostics) -> None:
    page = (Path(__file__).parents[2] / "docs" / "fusion_node.md").read_text()
    rows = page.partition("## Diagnostics")[2].partition("\n## ")[0]
    harness.fusion_node()
    harness.add(SensorSubscriber)
    for name in ("fusion", "s1", "s2", "rules", "gate", "check", "input"):
        node = "sensor_subscriber" if name == "input" else "fusion_node"
        (row,) = (line for line in rows.splitlines() if f"`{name}`" in line.split(" | ")[0])
        for value in diagnostics.next(f"{node}: {name}").values:
            counted = value.startswith(("dropped: ", "lost: "))
            assert f"`{value}`" in (page if counted else row)
    assert len(diagnostics.names) == 7


def test_sensors_that_stay_apart_are_said_by_the_node(
    harness: Harness, diagnostics: Diagnostics
) -> None:
    harness.fusion_node({"trigger": "pair"})
    feed = harness.feed()
    for k in range(22):
        feed(0.5 * k, s1=5.0, s2=0.0)
    text = "s1 and s2 have differed by 0.6 or more for 10.5 s: is one of them broken, or biased?"
    assert diagnostics.saying("fusion_node: rules", text).level == WARN


@pytest.mark.parametrize(
    ("tolerance", "text"),
    [
        (1e-9, "the gate rejects every prediction: raise gate.tolerance, or tune"),
        (1e9, "the gate accepts every prediction: lower gate.tolerance, or tune"),
    ],
)
def test_a_gate_that_is_of_no_use_is_said_by_the_node(
    harness: Harness, diagnostics: Diagnostics, tolerance: float, text: str
) -> None:
    predictor = {"predictor.enabled": True, "predictor.samples": 5}
    harness.fusion_node({"trigger": "pair", "gate.tolerance": tolerance, **predictor})
    feed = harness.feed()
    for k in range(ENOUGH + 10):
        feed(0.01 * k, s1=0.02 * k + 0.3 * (k % 2), s2=0.02 * k)
    status = diagnostics.saying("fusion_node: gate", text)
    assert status.level == WARN
    assert status.values["acceptance rate"] == ("0" if tolerance < 1.0 else "1")


def test_diagnostics_are_named_after_the_node(harness: Harness, diagnostics: Diagnostics) -> None:
    harness.fusion_node(arguments=("-r", "__node:=fuser"))
    diagnostics.next("fuser: fusion")


def test_what_is_adapted_is_reported(harness: Harness, diagnostics: Diagnostics) -> None:
    given = {"s1.bias_time_constant": 1.0, "s2.noise": 0.01, "s2.lag_time_constant": 0.01}
    harness.fusion_node({**given, "trigger": "pair", "adapt.scale_time_constant": 10.0})
    feed = harness.feed()
    for k in range(300):
        feed(0.01 * k, s1=1.3 * math.sin(0.05 * k), s2=math.sin(0.05 * k))
    shown = diagnostics.next("fusion_node: adaptation").values
    assert float(shown["S1's movements, times"]) == pytest.approx(1.0 / 1.3, rel=0.1)
    assert float(shown["S2's lag and delay, times"]) == 1.0
    assert float(shown["S2's lag (s)"]) == pytest.approx(0.01)
