# SPDX-License-Identifier: Apache-2.0
"""Claims and targets hold where they are true, fail where they are not, and say what decides."""

from __future__ import annotations

import json
from typing import Any

import pytest
from paper.outcomes import IAE, Change, outcomes, unchanged

from fuzzy_fusion_ros.paper.checks import CheckedClaim, place
from fuzzy_fusion_ros.paper.claims import claims
from fuzzy_fusion_ros.paper.claims_report import as_document, claims_table
from fuzzy_fusion_ros.paper.results import Results
from fuzzy_fusion_ros.paper.sweep import NOMINAL, Outcome, points_of
from fuzzy_fusion_ros.paper.targets import targets
from fuzzy_fusion_ros.text.table import WIDTH

FIGURES = range(6, 24)


def claimed(change: Change = unchanged) -> list[CheckedClaim]:
    """Return all claims about the changed world."""
    return claims(Results(outcomes(change)), FIGURES)


def aimed(change: Change = unchanged) -> list[CheckedClaim]:
    """Return all targets in the changed world."""
    return targets(Results(outcomes(change)), FIGURES)


def failing(checked: list[CheckedClaim]) -> set[tuple[int, str]]:
    """Return figure and first words of what does not hold."""
    return {(f.figure, " ".join(f.claim.split()[:3])) for f in checked if f.holds is False}


def where(condition: dict[str, object], **changes: object) -> Change:
    """Return a change of the outcomes of this method, at this point or at any.

    Args:
        condition: ``method`` and, where it is not at any, fields of the point.
        **changes: New values of fields; a function is given the old one.
    """

    def change(outcome: Outcome) -> Outcome:
        known = {"method": outcome.method, **outcome.point._asdict()}
        if any(known[name] != value for name, value in condition.items()):
            return outcome
        new: dict[str, Any] = {
            name: value(getattr(outcome, name)) if callable(value) else value
            for name, value in changes.items()
        }
        return outcome._replace(**new)

    return change


def times(factor: float) -> object:
    """Return a function that multiplies."""
    return lambda x: factor * x


def test_all_claims_hold_where_all_is_well() -> None:
    found = claimed()
    assert all(claim.holds for claim in found)
    assert [claim.figure for claim in found] == sorted(claim.figure for claim in found)
    assert {claim.figure for claim in found} == set(FIGURES) - {6, 12, 13}
    assert all(low <= c.value <= high for c in found for low, high in [c.interval])


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (where({"method": "s1"}, iae=times(0.08)), {(7, "S1 alone deviates")}),
        (where({"method": "s2"}, swing=0.1), {(8, "S2 alone oscillates"), (18, "S2 alone and")}),
        (where({"method": "no_drift"}, iae=times(0.3)), {(10, "without drift the")}),
        (where({"method": "aggregator"}, unrest=0.03), {(11, "the aggregator balances")}),
        (where({"method": "aggregator"}, s1_offset=0.01), {(14, "S1 is off")}),
        (where({"method": "aggregator"}, signal=0.009), {(15, "the estimate follows")}),
        (where({"method": "complete"}, rmse=0.008), {(16, "the predictor makes")}),
        (where({"method": "aggregator"}, iae=times(0.7)), {(16, "the predictor makes")}),
        (where({"method": "complete"}, rejected_pushed=0.1), {(17, "the gate ignores")}),
        (where({"method": "complete"}, rejected_calm=0.9), {(17, "the gate ignores")}),
        (where({"method": "complete"}, rejected_calm=float("nan")), {(17, "the gate ignores")}),
        (
            where({"method": "s2", "tau2": 0.05}, iae=0.11),
            {(18, "of S2, average")},
        ),
        (
            where({"method": "average", "sigma1": 0.02}, itae=1.0),
            {(21, "of S2, average"), (21, "ITAE shows it")},
        ),
        (where({"method": "average", "bias1": 0.06}, iae=0.1), {(22, "of S2, average")}),
        (where({"method": "average", "tau2": 0.3}, swing=0.0), {(18, "S2 alone and")}),
    ],
)
def test_a_claim_fails_where_it_is_not_true_and_no_other_does(
    change: Change, expected: set[tuple[int, str]]
) -> None:
    assert failing(claimed(change)) == expected


def test_the_average_must_be_worse_than_the_aggregator() -> None:
    found = failing(claimed(where({"method": "average"}, iae=times(0.13))))
    assert (9, "the plain average") in found


def test_itae_must_show_it_more_clearly_on_the_whole_of_a_sweep() -> None:
    """A single point where it does not is named but decides nothing."""

    def clearer(change: Change) -> CheckedClaim:
        return next(c for c in claimed(change) if c.figure == 23 and "clearly" in c.claim)

    one = clearer(where({"method": "s2", "bias1": 0.06}, itae=times(0.5)))
    assert one.holds
    assert one.where == "least: 0.62 at s2, bias₁ = 0.06 rad"
    assert not clearer(where({"method": "complete"}, itae=times(1.5))).holds


def test_a_claim_needs_its_whole_interval_on_the_right_side() -> None:
    """Better on average, but not beyond doubt."""

    def uncertain(outcome: Outcome) -> Outcome:
        if outcome.method != "complete":
            return outcome
        return outcome._replace(iae=outcome.iae * (1.6 if outcome.seed == 0 else 1.0))

    claim = next(c for c in claimed(uncertain) if "response better" in c.claim)
    assert claim.value < 1.0 < claim.interval[1]
    assert not claim.holds


def test_a_claim_about_a_sweep_names_the_point_that_decides() -> None:
    worse = claimed(where({"method": "s2", "tau2": 0.05}, iae=0.11))
    claim = next(c for c in worse if c.figure == 18 and "least" in c.claim)
    assert claim.where == "s2, τ₂ = 0.05 s"
    assert claim.value == pytest.approx(IAE["complete"] / 0.11, rel=0.02)


def test_claims_are_made_only_where_their_runs_are() -> None:
    nominal = Results(outcomes(points=points_of([])))
    assert {claim.figure for claim in claims(nominal, FIGURES)} == {7, 8, 9, 10, 11, 14, 15, 16, 17}
    with_bias = Results(outcomes(points=points_of(["bias1"])))
    assert {claim.figure for claim in claims(with_bias, range(18, 24))} == {22, 23}
    assert claims(nominal, [12]) == []
    assert claims(Results([]), FIGURES) == targets(Results([]), FIGURES) == []


def test_all_targets_are_met_where_all_is_well() -> None:
    found = aimed()
    assert failing(found) == set()
    assert {target.figure for target in found} == {11, 15, 16, 18, 20, 22}
    assert sum(target.holds is None for target in found) == 15 - 1 - 3


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (
            where({"method": "aggregator"}, iae=0.2),
            {(11, "the aggregator's IAE")},
        ),
        (where({"method": "aggregator"}, rmse=0.0081), {(15, "the aggregator's error")}),
        (where({"method": "complete"}, rmse=0.006), {(16, "the predictor lowers")}),
        (
            where({"method": "complete", **NOMINAL._asdict()}, iae=times(1.3)),
            {(16, "the predictor lowers")},
        ),
        (where({"method": "kalman", **NOMINAL._asdict()}, iae=0.1), {(16, "fusion is near")}),
        (
            where({"method": "aggregator", "bias1": 0.1}, iae=0.1),
            {(22, "the predictor costs")},
        ),
        (where({"method": "s1", "sigma1": 0.02}, iae=0.1), {(20, "fusion is ahead")}),
        (where({"method": "kalman", "tau2": 0.1}, iae=0.1), {(18, "fusion is ahead")}),
        (where({"method": "kalman", "tau2": 0.3}, iae=0.01), set()),
    ],
)
def test_a_target_is_missed_where_it_is(change: Change, expected: set[tuple[int, str]]) -> None:
    assert failing(aimed(change)) == expected


def test_places_are_named_by_what_is_not_nominal() -> None:
    assert place(NOMINAL) == "nominal"
    assert place(NOMINAL._replace(sigma1=0.15)) == "σ₁ = 0.15 rad"
    assert place(NOMINAL._replace(tau2=0.3, bias1=0.1)) == "τ₂ = 0.3 s, bias₁ = 0.1 rad"


def test_the_table_says_what_fails_and_by_how_much() -> None:
    found = claimed(where({"method": "s2", "tau2": 0.05}, iae=0.11))
    lines = claims_table(found, "claim", "holds").splitlines()
    assert max(map(len, lines)) <= WIDTH
    assert sum(line[0] != " " for line in lines) == 1 + len(found)
    assert lines[0].split() == ["fig.", "value", "95", "%", "interval", "claim"]
    failed = [i for i, line in enumerate(lines) if "FAILS" in line]
    assert len(failed) == 1
    assert lines[failed[0]].startswith("18 ")
    where_it_fails = " ".join(" ".join(lines[failed[0] + 2 : failed[0] + 4]).split())
    assert where_it_fails == "(IAE of complete ÷ rival < 1; s2, τ₂ = 0.05 s)"
    assert claims_table([], "claim", "holds") == ""


def test_a_value_without_a_bound_neither_holds_nor_fails() -> None:
    table = claims_table(aimed(), "target", "met")
    assert table.count("–  ") == 11
    assert "FAILS" not in table


def test_the_document_is_the_json_that_users_rely_on() -> None:
    runs = outcomes()
    nan = where({"method": "complete"}, rejected_calm=float("nan"))
    document = json.loads(json.dumps(as_document(runs, claimed(nan), aimed()), allow_nan=False))
    assert len(document["runs"]) == len(runs)
    keys = {"method", "tau2", "sigma1", "bias1", "seed", "iae", "itae", "rmse", "fell"}
    assert all(set(run) == keys for run in document["runs"])
    pinned = {"figure", "claim", "holds", "value", "interval"}
    for check in document["claims"] + document["targets"]:
        assert pinned <= set(check)
        assert len(check["interval"]) == 2
    only_temporarily = next(c for c in document["claims"] if "temporarily" in c["claim"])
    assert only_temporarily["value"] is None
    assert only_temporarily["holds"] is False
