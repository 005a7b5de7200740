# SPDX-License-Identifier: Apache-2.0
"""Scores of a whole recording."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from bag.recorded import Scalar, read, swing, write_scalars
from numpy.typing import NDArray

from fuzzy_fusion_ros.bag import BagWriter, open_bag
from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, baselines_for
from fuzzy_fusion_ros.batch.arrays import Reals
from fuzzy_fusion_ros.batch.series import Series
from fuzzy_fusion_ros.messages.outputs import RULES
from fuzzy_fusion_ros.offline.replay import replay
from fuzzy_fusion_ros.offline.topics import Topics
from fuzzy_fusion_ros.parameters.errors import BagError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import replace
from fuzzy_fusion_ros.scoring import score as score_module
from fuzzy_fusion_ros.scoring.metrics import METRICS, ScoreError
from fuzzy_fusion_ros.scoring.report import BEST_BASELINE, report, summary, table
from fuzzy_fusion_ros.scoring.score import DERIVED, FITTED, GIVEN, Fit, Score, score_bag
from fuzzy_fusion_ros.text.table import WIDTH


def scored(
    path: Path,
    topics: Topics | None = None,
    baselines: BaselineParameters | Fit | None = None,
    start_s: float | None = None,
    end_s: float | None = None,
    changes: dict[str, object] | None = None,
) -> Score:
    """Score a bag."""
    parameters = replace(Parameters(), changes or {})
    return score_bag(path, topics or Topics(), parameters, baselines, start_s, end_s)


@pytest.fixture
def bag(tmp_path: Path) -> Path:
    """A bag with everything."""
    return write_scalars(tmp_path / "bag", swing())


def test_the_estimate_s_own_standard_deviation_is_scored(tmp_path: Path) -> None:
    """Where the fusion runs here, and where a replayed bag holds it: the same."""
    raw = write_scalars(tmp_path / "raw", swing(estimate=False))
    computed = scored(raw)
    with open_bag(raw) as bag:
        replay(bag, tmp_path / "new", Topics(), Parameters())
    replayed = scored(tmp_path / "new")
    for score in (computed, replayed):
        found = score.as_json()["estimators"]["estimate"]
        assert 0.0 <= found["within_1sd"] <= found["within_2sd"] <= 1.0
        assert np.isfinite(found["nll"])
        assert "within_1sd" not in score.as_json()["estimators"]["s1"]
        assert "within_2sd" in report(score)
    assert np.array_equal(computed.deviations["estimate"], replayed.deviations["estimate"])


def test_the_figures_are_those_of_the_samples(bag: Path) -> None:
    score = scored(bag)
    found = score.scores("estimate")
    assert found["rmse"] == pytest.approx(0.01)
    assert found["bias"] == pytest.approx(0.01)
    assert found["iae"] == pytest.approx(0.05)
    assert found["itae"] == pytest.approx(0.01 * 0.01 * sum(k * 0.01 for k in range(500)))
    assert score.scores("s1")["bias"] == pytest.approx(0.1)
    rmses = {name: score.scores(name)["rmse"] for name in BASELINES}
    assert rmses[score.best_baseline] == min(rmses.values())
    assert (score.matched, score.of) == (500, 500)
    assert score.span_s == pytest.approx((0.0, 4.99))
    assert not score.recomputed


def test_the_json_is_as_documented(bag: Path) -> None:
    document = json.loads(json.dumps(scored(bag).as_json(), allow_nan=False))
    assert list(document) == [
        "matched",
        "of",
        "every",
        "span_s",
        "unit",
        "best_baseline",
        "estimators",
    ]
    assert document["unit"] is None
    assert list(document["estimators"]) == ["estimate", *BASELINES]
    required = {"estimate", "s1", "s2", "average", "complementary", "kalman", "kalman_bias"}
    assert required <= set(document["estimators"])
    sure = {"kalman", "kalman_bias", "kalman_lag", "kalman_lag_cv", "error_state"}
    for name, values in document["estimators"].items():
        measures = ["rmse", "mae", "iae", "itae", "max", "bias"]
        if name in sure:
            measures += ["within_1sd", "within_2sd", "nll"]
        assert list(values) == measures


def test_all_are_scored_at_the_same_stamps(bag: Path) -> None:
    score = scored(bag)
    assert {values.size for values in score.values.values()} == {score.matched}
    assert np.isfinite([*score.values.values()]).all()
    assert np.array_equal(
        score.values["average"], 0.5 * score.values["s1"] + 0.5 * score.values["s2"]
    )


def test_truth_is_interpolated_never_extrapolated(tmp_path: Path) -> None:
    sparse = swing(truth=False) + [
        Scalar("/truth", time_s, 2.0 * time_s, log_s=5.0) for time_s in (1.0, 2.0, 3.005)
    ]
    score = scored(write_scalars(tmp_path / "bag", sparse))
    assert (score.matched, score.of) == (201, 500)
    assert score.truth == pytest.approx(2.0 * np.arange(1.0, 3.005, 0.01))
    assert score.span_s == pytest.approx((1.0, 3.0))


def test_what_comes_before_s2_is_not_scored(tmp_path: Path) -> None:
    late = [each for each in swing() if each.topic != "/s2" or each.time_s >= 1.0]
    score = scored(write_scalars(tmp_path / "bag", late))
    assert (score.matched, score.of) == (400, 500)


def test_estimates_at_other_stamps_are_scored_against_what_was_known(tmp_path: Path) -> None:
    shifted = [
        each._replace(time_s=each.time_s + 0.004) if each.topic == "/estimate" else each
        for each in swing()
    ]
    score = scored(write_scalars(tmp_path / "bag", shifted))
    assert (score.matched, score.of) == (499, 500)
    assert score.values["s1"][100] == pytest.approx(1.0 * 4.0 + 0.1)


def test_without_an_estimate_the_fusion_runs(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(estimate=False))
    score = scored(path)
    assert score.recomputed
    assert score.of == 500
    assert set(score.behind) == {"weight", "drift", *RULES}
    assert sum(score.behind[rule] for rule in RULES) == pytest.approx(np.ones(500))
    other = scored(path, changes={"aggregator.weight.small": 0.9})
    assert other.scores("estimate")["rmse"] != score.scores("estimate")["rmse"]
    assert other.scores("kalman") == score.scores("kalman")


def test_what_stands_behind_the_estimate_comes_from_the_bag(tmp_path: Path) -> None:
    beside = [Scalar("/fusion_node/weight", k * 0.01, 0.25, log_s=5.0) for k in range(500)]
    path = write_scalars(tmp_path / "bag", [*swing(), *beside])
    score = scored(path)
    assert list(score.behind) == ["weight"]
    assert set(score.behind["weight"]) == {0.25}


def test_estimates_are_explained_by_their_replay_or_by_equal_ones(tmp_path: Path) -> None:
    changes: dict[str, object] = {"aggregator.weight.small": 0.9}
    source = write_scalars(tmp_path / "bag", swing())
    with open_bag(source) as bag:
        replay(bag, tmp_path / "replayed", Topics(), replace(Parameters(), changes))
    kept = ("/s1", "/s2", "/truth", "/estimate")
    with open_bag(tmp_path / "replayed") as bag, BagWriter(tmp_path / "bare") as writer:
        for message in bag.messages(kept):
            writer.write(*message)
    explained = scored(tmp_path / "replayed").behind
    assert set(explained) == {"weight", "drift", *RULES}
    equal = scored(tmp_path / "bare", changes=changes).behind
    assert {name: values.tolist() for name, values in equal.items()} == {
        name: values.tolist() for name, values in explained.items()
    }
    assert scored(tmp_path / "bare").behind == {}


def test_baselines_follow_the_recording_or_what_is_given(bag: Path) -> None:
    given = replace(BaselineParameters(), {"constant_weight.weight": 1.0})
    fitted, derived = scored(bag, baselines=given), scored(bag)
    assert (fitted.baselines, derived.baselines) == (GIVEN, DERIVED)
    assert fitted.scores("constant_weight") == derived.scores("s1")


class Asked:
    """A fit that keeps what it is asked for."""

    def __init__(self) -> None:
        """Begin with nothing asked."""
        self.seen: list[tuple[Series, Reals, NDArray[np.bool_]]] = []

    def __call__(
        self, series: Series, truth: Reals, where: NDArray[np.bool_]
    ) -> BaselineParameters:
        """Keep it, and answer that S1 is all."""
        self.seen.append((series, truth, where))
        return replace(BaselineParameters(), {"constant_weight.weight": 1.0})


def test_baselines_are_fitted_where_they_are_scored(bag: Path) -> None:
    fit = Asked()
    score = scored(bag, baselines=fit, start_s=1.0, end_s=2.0)
    ((series, truth, where),) = fit.seen
    assert series.s1.size == 200  # the filters warm up before
    assert where.nonzero()[0].tolist() == list(range(100, 200))
    assert truth[where].tolist() == score.truth.tolist()
    assert score.baselines == FITTED
    assert score.scores("constant_weight") == score.scores("s1")


def test_nothing_is_fitted_where_nothing_matches(tmp_path: Path) -> None:
    apart = [
        each._replace(time_s=each.time_s - 100.0, log_s=each.time_s)
        if each.topic == "/truth"
        else each
        for each in swing(1.0)
    ]
    fit = Asked()
    with pytest.raises(ScoreError, match="matched 0 of 100"):
        scored(write_scalars(tmp_path / "bag", apart), baselines=fit)
    assert fit.seen == []


def test_baselines_are_not_fitted_where_s1_has_a_gap(tmp_path: Path) -> None:
    lost = {"/s1": (0.895, 0.985), "/truth": (0.985, 1.0)}
    scalars = [
        each
        for each in swing(1.0)
        if each.topic not in lost or not lost[each.topic][0] < each.time_s < lost[each.topic][1]
    ]
    score = scored(write_scalars(tmp_path / "bag", scalars), baselines=Asked(), start_s=0.945)
    assert (score.matched, score.baselines) == (4, DERIVED)


def test_a_span_is_scored_as_if_it_were_all(bag: Path) -> None:
    score = scored(bag, start_s=1.0, end_s=2.0)
    assert (score.matched, score.of) == (100, 100)
    assert score.span_s == pytest.approx((1.0, 1.99))
    assert score.scores("estimate")["itae"] == pytest.approx(
        0.01 * 0.01 * sum(k * 0.01 for k in range(100))
    )


def test_no_match_says_why(tmp_path: Path) -> None:
    apart = [
        each._replace(time_s=each.time_s + 1e6, log_s=each.time_s)
        if each.topic == "/truth"
        else each
        for each in swing(1.0)
    ]
    path = write_scalars(tmp_path / "bag", apart)
    with pytest.raises(ScoreError, match=r"matched 0 of 100 estimates: their stamps are 17000\d+"):
        scored(path, changes={"future_tolerance": 1e9})
    with pytest.raises(ScoreError, match="those of the truth none"):
        scored(path)


def test_a_truth_must_be_there(tmp_path: Path) -> None:
    path = write_scalars(tmp_path / "bag", swing(1.0, truth=False))
    with pytest.raises(BagError, match="has no topic '/truth'; it has /estimate"):
        scored(path)


@pytest.mark.parametrize("trigger", ["pair", "timer"])
def test_other_triggers_are_scored_too(tmp_path: Path, trigger: str) -> None:
    path = write_scalars(tmp_path / "bag", swing(estimate=False))
    score = scored(path, changes={"trigger": trigger, "rate": 20.0})
    assert score.matched in range(40, 101)


@pytest.mark.parametrize("estimate", [True, False])
def test_pairs_that_never_come_match_nothing(estimate: bool, tmp_path: Path) -> None:
    apart = [
        each._replace(time_s=each.time_s + 0.001) if each.topic == "/s1" else each
        for each in swing(0.5, estimate=estimate)
    ]
    path = write_scalars(tmp_path / "bag", apart)
    with pytest.raises(ScoreError, match=f"matched 0 of {50 * estimate} estimates"):
        scored(path, changes={"trigger": "pair"})


def test_the_table_has_every_metric_and_estimator(bag: Path) -> None:
    score = scored(bag)._replace(unit="rad")
    lines = table(score).splitlines()
    assert max(map(len, lines)) <= WIDTH
    blocks = "\n".join(lines).split("\n\n")
    assert [name for block in blocks for name in block.splitlines()[0].split()] == list(METRICS)
    assert any(" rad^2 " in block.splitlines()[1] for block in blocks)
    for block in blocks:
        rows = [row.split() for row in block.splitlines()[2:]]
        assert [row[0] for row in rows] == ["estimate", *BASELINES]
        assert [row[0] for row in rows if row[1] == BEST_BASELINE] == [score.best_baseline]


def test_the_best_of_each_column_is_marked(bag: Path) -> None:
    score = scored(bag)
    text = table(score, ("rmse", "bias")).replace(f" {BEST_BASELINE} ", "   ")
    rows = [line.split() for line in text.splitlines()]
    assert rows[:2] == [["rmse", "bias"], []]
    for k, metric in enumerate(("rmse", "bias"), 1):
        values = {name: abs(score.scores(name)[metric]) for name in score.values}
        best = {name for name, value in values.items() if value == min(values.values())}
        assert {row[0] for row in rows[2:] if row[k].endswith("*")} == best


def test_a_lag_at_the_end_of_the_search_is_shown_as_longer(bag: Path) -> None:
    time_s = np.arange(0.0, 100.0, 0.01)
    values = {"s1": np.tanh(time_s - 55.0), "s2": np.tanh(time_s - 35.0), "average": time_s}
    score = scored(bag)._replace(
        time_s=time_s, truth=np.tanh(time_s - 45.0), values=values, deviations={}, gap_s=0.0
    )
    shown = {row[0]: row[-1] for row in map(str.split, table(score, ("lag",)).splitlines()[2:])}
    assert shown["s1"] == ">2"
    assert shown["s2"] == "<-2"
    assert shown["average"][0] not in "<>"


def test_an_unknown_unit_is_left_open(bag: Path) -> None:
    assert table(scored(bag), ("rmse", "sse", "lag")).splitlines()[1].split() == ["s"]


def test_the_summary_says_what_matched(bag: Path) -> None:
    score = scored(bag)._replace(name="bag")
    assert summary(score).splitlines() == [
        "bag",
        "500 of 500 estimates matched to the truth, 0.00 s to 4.99 s; estimate: from the",
        "bag; baselines: as the recording suggests them, not fitted; the best of them is",
        "marked +; modes: FUSED 100 % of the time",
    ]
    assert "which flatters them" in summary(score._replace(baselines=FITTED))
    assert "estimate: computed" in summary(score._replace(recomputed=True))


def test_defaults_are_derived_once_per_recording(bag: Path) -> None:
    score = scored(bag)
    given = baselines_for(read(bag).series)
    assert scored(bag, baselines=given).as_json() == score.as_json()


def test_estimates_in_a_gap_of_the_truth_are_not_scored(tmp_path: Path) -> None:
    whole = swing()
    gap = [each for each in whole if each.topic != "/truth" or not 1.0 < each.time_s < 3.0]
    score = scored(write_scalars(tmp_path / "gap", gap))
    assert score.of - score.matched == 199
    assert "199 estimates are in gaps of the truth and are not scored" in score.notes
    scores, others = score.scores("estimate"), scored(write_scalars(tmp_path / "whole", whole))
    assert scores["max"] <= others.scores("estimate")["max"]
    assert scores["iae"] == pytest.approx(scores["mae"] * 0.01 * score.matched, rel=0.01)
    assert not any("gaps" in note for note in others.notes)


@pytest.mark.parametrize("estimate", [True, False])
def test_of_a_long_recording_one_estimate_in_so_many_is_scored(
    estimate: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_scalars(tmp_path / "bag", swing(estimate=estimate))
    whole = scored(bag)
    monkeypatch.setattr(score_module, "MOST", 100)
    thinned = scored(bag)
    assert thinned.notes == (*whole.notes, "more than 100 estimates: one in 5 is scored")
    assert (whole.as_json()["every"], thinned.as_json()["every"]) == (1, 5)
    assert thinned.scores("s1")["sse"] == pytest.approx(whole.scores("s1")["sse"], rel=0.05)
    assert 5 * (thinned.matched - 1) <= whole.matched <= 5 * (thinned.matched + 1)
    at = np.isin(whole.time_s.round(6), thinned.time_s.round(6))
    for name, values in thinned.values.items():
        assert values.tolist() == whole.values[name][at].tolist()
    foreign = [Scalar("/estimate", 0.003 + 0.01 * k, 0.1) for k in range(400)]
    other = write_scalars(
        tmp_path / "other",
        sorted([*swing(estimate=False), *foreign], key=lambda each: each.time_s),
    )
    assert scored(other).matched > 300


@pytest.mark.parametrize("estimate", [True, False])
def test_a_span_of_a_long_recording_is_thinned_by_its_own_length(
    estimate: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = write_scalars(tmp_path / "bag", swing(estimate=estimate))
    whole = scored(bag, start_s=4.2)
    monkeypatch.setattr(score_module, "MOST", 100)
    kept = scored(bag, start_s=4.2)
    assert kept.as_json() == whole.as_json()
    assert kept.notes == whole.notes
    half = scored(bag, start_s=3.2)
    assert half.every == 2


def test_filters_have_run_from_the_first_message_on_when_a_span_is_scored(bag: Path) -> None:
    """A filter that began at the span's start would still be settling there."""
    baselines = baselines_for(read(bag).series)
    whole = scored(bag, baselines=baselines, changes={"predictor.enabled": True})
    late = scored(bag, baselines=baselines, start_s=2.0)
    for name in BASELINES:
        assert late.values[name].tolist() == whole.values[name][-late.matched :].tolist()


def test_metrics_and_estimators_that_do_not_exist_are_refused(bag: Path) -> None:
    found = scored(bag)
    with pytest.raises(ScoreError, match="there is no metric 'rsme': expected one of rmse, "):
        found.scores("estimate", ["rmse", "rsme"])
    with pytest.raises(ScoreError, match="there is no estimator 'kalmann': expected one of est"):
        found.scores("kalmann")
