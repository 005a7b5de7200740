# SPDX-License-Identifier: Apache-2.0
"""A whole fit: better than either sensor on what it has not seen, and repeatable."""

from __future__ import annotations

import sys
from collections.abc import Iterator

import numpy as np
import pytest
from tuning.quick import be_quick
from tuning.recordings import START_NS, Made, Sensors, made
from tuning.standins import standin

from fuzzy_fusion_ros.baselines import BASELINES, BaselineParameters, methods
from fuzzy_fusion_ros.batch.arrays import Reals, Stamps, root_mean_square
from fuzzy_fusion_ros.batch.lag import TRUSTED, Lag
from fuzzy_fusion_ros.batch.series import Series, fusion, run, values
from fuzzy_fusion_ros.core.estimator import FUSED
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import flatten, replace
from fuzzy_fusion_ros.self_tuning.homes import safety_net
from fuzzy_fusion_ros.tuning import (
    Trial,
    Tuned,
    TuneError,
    baselines,
    characterise,
    fit_baselines,
    tune,
    tune_to,
)
from fuzzy_fusion_ros.tuning.candidates import Candidate, candidates_for
from fuzzy_fusion_ros.tuning.fit import Problem
from fuzzy_fusion_ros.tuning.kernel import joined
from fuzzy_fusion_ros.tuning.model_selection import (
    BLOCKS,
    ENOUGH_S2,
    FittedCandidate,
    chosen,
    errors_by_part,
    folds_of,
    parts_of,
    refitted,
)
from fuzzy_fusion_ros.tuning.report import as_json, comments, described, outcome
from fuzzy_fusion_ros.tuning.search import Pool
from fuzzy_fusion_ros.tuning.space import SURE
from fuzzy_fusion_ros.tuning.together import oddities, typical
from fuzzy_fusion_ros.tuning.tune import (
    ADAPTING_PAYS,
    BOUNDING_COSTS,
    INSTANT,
    NO_WORSE,
    OUTLIER_THRESHOLD,
    SHORTENING_COSTS,
    UNSEEN,
    WITHIN,
    adapting_if_better,
    bounded_if_cheap,
    error_of,
    rounded,
    shorten_bias_time_constant,
    simplified,
    with_deviation,
    with_predictor,
    with_safety_net,
)

SENSORS = Sensors(bias=0.4, noise=0.1, delay=0.2)
GIVEN = replace(Parameters(), {"qos": "reliable", "s2.field": "point.x", "rate": 50.0})


@pytest.fixture(scope="module")
def recording() -> Made:
    """What is fitted to."""
    return made(SENSORS)


@pytest.fixture(scope="module")
def unseen() -> Made:
    """Another recording of the same sensors."""
    return made(SENSORS, seed=1)


@pytest.fixture(scope="module")
def patch() -> Iterator[pytest.MonkeyPatch]:
    """Changes for all tests of this file: little effort."""
    with pytest.MonkeyPatch.context() as context:
        be_quick(context)
        yield context


@pytest.fixture(scope="module")
def tuned(recording: Made, patch: pytest.MonkeyPatch) -> Tuned:
    """A fit to the truth."""
    return tune(recording.series, recording.truth, GIVEN, threads=2)


def rmse(values: Reals, recording: Made) -> float:
    """Return the error of an estimate where S2 is known."""
    known = recording.series.s2_known > 0
    return float(np.sqrt(np.mean(np.square((values - recording.truth)[known]))))


NEARLY = 1.1
"""How far a short fit may be behind a filter that models exactly what the recording was made by."""


BLIND = 1.25
"""How far a short fit without a truth may be behind a filter that is fitted to the reference."""


def test_it_is_good_on_what_it_has_not_seen(tuned: Tuned, unseen: Made) -> None:
    ours = rmse(run(fusion(tuned.parameters), unseen.series).value, unseen)
    others = {
        name: rmse(run(method, unseen.series).value, unseen)
        for name, method in methods(tuned.baselines).items()
    }
    knowing = {name: others.pop(name) for name in ("kalman_lag", "kalman_lag_cv", "error_state")}
    assert ours < min(others.values())
    assert ours < NEARLY * min(knowing.values())


def test_without_a_truth_too(recording: Made, unseen: Made, patch: pytest.MonkeyPatch) -> None:
    """Far ahead of both sensors; S2 alone does not show how far S1's noise should be smoothed."""
    blind = tune(recording.series)
    assert not blind.with_truth
    ours = rmse(run(fusion(blind.parameters), unseen.series).value, unseen)
    others = {
        name: rmse(run(method, unseen.series).value, unseen)
        for name, method in methods(blind.baselines).items()
    }
    assert ours < 0.2 * min(others["s1"], others["s2"])
    assert ours < BLIND * min(others.values())
    best = next(each for each in blind.candidates if each.name == blind.chosen)
    worse = max(best.unseen_parts) / best.fitted
    assert blind.parameters.estimate.deviation_scale == pytest.approx(UNSEEN * worse, rel=1e-3)


def test_it_repeats_itself_whatever_the_threads(tuned: Tuned, recording: Made) -> None:
    again = tune(recording.series, recording.truth, GIVEN, threads=1)
    assert again.parameters == tuned.parameters
    assert again.baselines == tuned.baselines
    assert as_json(again, "") == as_json(tuned, "")


@pytest.mark.slow("another fit")
def test_another_seed_leads_elsewhere(tuned: Tuned, recording: Made) -> None:
    other = tune(recording.series, recording.truth, GIVEN, seed=1)
    assert other.parameters != tuned.parameters


def test_the_rest_of_the_parameters_stays(tuned: Tuned) -> None:
    after = flatten(tuned.parameters)
    assert (after["qos"], after["s2.field"], after["rate"]) == ("reliable", "point.x", 50.0)


def test_a_lost_s2_is_soon_noticed(tuned: Tuned) -> None:
    assert tuned.parameters.s2.timeout == pytest.approx(0.6)


@pytest.mark.parametrize(("interval", "lost"), [(0.01, 0.5), (0.1, 0.5), (1.0, 3.0), (1e-5, 5e-4)])
def test_an_s2_that_a_busy_computer_delays_is_not_lost(
    recording: Made, interval: float, lost: float
) -> None:
    sensors = characterise(recording.series)
    sensors = sensors._replace(s2_interval=interval, s2_pause=interval, s2_delivery=0.0)
    for each in candidates_for(sensors)[1:]:
        assert each.spec.space.fixed["s2.timeout"] == pytest.approx(lost)


def test_an_s2_that_is_delivered_late_is_not_taken_for_lost(patch: pytest.MonkeyPatch) -> None:
    series, truth = made(SENSORS)
    late_s2 = series._replace(s2_known=np.append(np.zeros(50, np.int64), series.s2_known[:-50]))
    sensors = characterise(late_s2)
    assert sensors.s2_delivery == pytest.approx(2.0, abs=0.05)
    assert "delivered up to 2 s after" in "\n".join(described(sensors, ""))
    result = tune(late_s2, truth)
    trace = run(fusion(result.parameters), late_s2)
    assert result.parameters.s2.timeout == pytest.approx(2.6, abs=0.05)
    assert np.mean(trace.mode == FUSED) > 0.9


def test_a_slow_process_is_tuned_and_beats_the_better_sensor(patch: pytest.MonkeyPatch) -> None:
    series, truth = standin("block_temp", 0)
    result = tune(series, truth)
    assert result.sensors.lag.total == pytest.approx(160.0, rel=0.05)
    assert result.error < 0.7 * min(result.baseline_errors["s1"], result.baseline_errors["s2"])
    assert "S1: one sample in 3 s" in "\n".join(comments(result, "K", "a bag"))


@pytest.mark.parametrize(
    "scale", [1e-4, pytest.param(1e5, marks=pytest.mark.slow("the other way"))]
)
def test_any_scale_of_time_and_signal_is_tuned(scale: float, patch: pytest.MonkeyPatch) -> None:
    series, truth = made(SENSORS)

    def scaled(stamps_ns: Stamps) -> Stamps:
        return START_NS + np.round((stamps_ns - START_NS) * scale).astype(np.int64)

    signal = 1.0 / scale
    result = tune(
        Series(
            scaled(series.s1_ns),
            signal * series.s1,
            scaled(series.s2_ns),
            signal * series.s2,
            series.s2_known,
        ),
        signal * truth,
    )
    assert result.error < min(result.baseline_errors["s1"], result.baseline_errors["s2"])


def test_the_fit_is_what_it_says(tuned: Tuned, recording: Made) -> None:
    value = run(fusion(tuned.parameters), recording.series).value
    assert tuned.error == rmse(value, recording)
    assert tuned.error < tuned.before_error
    assert tuned.error <= min(tuned.baseline_errors["s1"], tuned.baseline_errors["s2"])
    for name, method in methods(tuned.baselines).items():
        error = rmse(run(method, recording.series).value, recording)
        assert error == pytest.approx(tuned.baseline_errors[name])


def test_linear_filters_err_as_far_as_they_say(tuned: Tuned, recording: Made) -> None:
    known = recording.series.s2_known > 0
    for name in ("kalman", "kalman_bias"):
        trace = run(methods(tuned.baselines)[name], recording.series)
        error = (trace.value - recording.truth)[known]
        assert root_mean_square(error / trace.standard_deviation[known]) == pytest.approx(1.0)


def test_baselines_are_fitted_alone_too(tuned: Tuned, recording: Made) -> None:
    known = recording.series.s2_known > 0
    told: list[tuple[int, int]] = []
    alone = fit_baselines(
        recording.series, recording.truth, known, progress=lambda *far: told.append(far)
    )
    assert alone.parameters == tuned.baselines
    assert told[-1][0] == told[-1][1]


def test_a_useless_s1_leaves_s2(patch: pytest.MonkeyPatch) -> None:
    series, truth = made(Sensors(lag=0.0))
    noise = 100.0 * np.random.default_rng(5).standard_normal(truth.size)
    result = tune(series._replace(s1=noise), truth)
    assert result.error <= 1.01 * result.baseline_errors["s2"]


def test_without_a_truth_an_s1_that_has_nothing_to_do_with_s2_leaves_s2(
    patch: pytest.MonkeyPatch,
) -> None:
    series, truth = made(Sensors(lag=0.2))
    for useless in (np.random.default_rng(5).standard_normal(truth.size), 0.0 * truth):
        result = tune(series._replace(s1=useless))
        assert result.chosen == "s2"
        assert result.error == 0.0
        assert "no more in common than unrelated signals" in "\n".join(
            comments(result, "", "a bag")
        )


def test_without_a_truth_an_s1_that_needs_no_bias_is_left_alone(patch: pytest.MonkeyPatch) -> None:
    series, truth = made(Sensors(bias=0.0, noise=0.0))
    poor = series.s2 + 0.3 * np.random.default_rng(5).standard_normal(series.s2.size)
    result = tune(series._replace(s2=poor))
    value = run(fusion(result.parameters), series._replace(s2=poor)).value
    assert rmse(value, Made(series, truth)) < 0.01


def test_a_lag_beyond_its_search_range_is_fitted_without_a_truth(
    patch: pytest.MonkeyPatch,
) -> None:
    series, truth = made(Sensors(delay=3.0, lag=0.0))  # a twentieth of 40 s is 2 s
    noise = 0.25 * np.random.default_rng(5).standard_normal(series.s2.size)
    noisy = series._replace(s2=series.s2 + noise)
    result = tune(noisy)
    assert result.sensors.lag_at_limit
    assert TRUSTED < result.sensors.lag.correlation < SURE
    found = result.parameters.s2
    assert found.delay + found.lag_time_constant == pytest.approx(3.0, abs=0.3)
    assert rmse(run(fusion(result.parameters), noisy).value, Made(noisy, truth)) < 0.2


def test_the_bias_is_learnt_as_quickly_as_costs_next_to_nothing(recording: Made) -> None:
    series, truth = recording
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    weights = {f"aggregator.weight.{each}": 0.0 for each in _WEIGHTS}
    slow = replace(
        Parameters(), {**weights, "s1.bias_time_constant": 100.0, **_LAG, "s2.noise": 0.1}
    )
    quick = shorten_bias_time_constant(problem, slow)
    assert quick.s1.bias_time_constant < 100.0
    assert problem.misfit(quick) <= SHORTENING_COSTS * problem.misfit(slow)
    unlearnt = replace(slow, {"s1.bias_time_constant": INSTANT * 0.1})
    assert shorten_bias_time_constant(problem, unlearnt) == unlearnt


def test_innovations_of_s2_are_bounded_where_that_costs_next_to_nothing(recording: Made) -> None:
    series, truth = recording
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    weights = {f"aggregator.weight.{each}": 0.0 for each in _WEIGHTS}
    learning = replace(Parameters(), {**weights, "s1.bias_time_constant": 0.5, **_LAG})
    bounded = fitted_as(replace(learning, {"s2.outlier_threshold": OUTLIER_THRESHOLD}))
    candidate = candidate_of("bias", series)
    assert bounded_if_cheap(problem, candidate, bounded, 2, 0) == bounded
    blend = fitted_as(replace(bounded.parameters, {"s1.bias_time_constant": 0.0}))
    found = bounded_if_cheap(problem, candidate, blend, 2, 0)
    assert found.parameters.s2.outlier_threshold == 0.0
    assert found.unseen == blend.unseen


def test_where_the_bound_is_removed_the_rest_is_fitted_and_validated_without_it(
    recording: Made, patch: pytest.MonkeyPatch
) -> None:
    series, truth = recording
    problem = Problem(
        [series],
        truth,
        series.s2_known > 0,
        replace(Parameters(), {"s2.outlier_threshold": 0.1}),
    )
    candidate = candidate_of("bias", series)
    space = candidate.spec.space
    off = {"s1.bias_time_constant": 50.0, **_LAG}
    tight = fitted_as(replace(problem.base, {**space.values(space.point({})), **off}))
    loose = replace(tight.parameters, {"s2.outlier_threshold": 0.0})
    assert problem.misfit(tight.parameters) > BOUNDING_COSTS * problem.misfit(loose)
    found = bounded_if_cheap(problem, candidate, tight, 2, 0)
    assert found.parameters.s2.outlier_threshold == 0.0
    assert found.parameters.s1.bias_time_constant != loose.s1.bias_time_constant
    assert found.fitted == problem.misfit(found.parameters) < 0.9 * problem.misfit(loose)
    assert len(found.unseen_parts) == BLOCKS
    assert found.unseen == pytest.approx(found.fitted, rel=0.1)
    assert bounded_if_cheap(problem, candidate, tight, 1, 0) == found


def test_the_table_shows_the_fit_without_the_bound(
    recording: Made, patch: pytest.MonkeyPatch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys.modules[bounded_if_cheap.__module__], "BOUNDING_COSTS", 0.0)
    tuned = tune(recording.series, recording.truth, threads=2)
    assert tuned.parameters.s2.outlier_threshold == 0.0
    shown = next(each for each in tuned.candidates if each.name == tuned.chosen)
    assert shown.parameters.s2.outlier_threshold == 0.0
    problem = Problem(
        [recording.series], recording.truth, recording.series.s2_known > 0, Parameters()
    )
    assert shown.fitted == problem.misfit(shown.parameters)
    assert tuned.recordings[0].unseen_error == shown.unseen


@pytest.mark.parametrize(("scale", "adapts"), [(1.0, False), (1.4, True)])
def test_a_wrong_scale_of_s1_is_adapted(
    recording: Made, patch: pytest.MonkeyPatch, scale: float, adapts: bool
) -> None:
    """Where that pays at once, and on unseen parts."""
    series = recording.series._replace(s1=scale * recording.series.s1)
    problem = Problem([series], recording.truth, series.s2_known > 0, Parameters())
    sensors = characterise(series)
    candidate = candidate_of("bias", series)
    space = candidate.spec.space
    start = replace(Parameters(), space.values(space.point({})))
    with Pool(2, lambda done, of: None, 0) as pool:
        fixed = refitted(problem, candidate, start, pool, 0)
    if adapts:  # as a fit sometimes ends, where adaptation cannot follow
        lost = {"s2.lag_time_constant": 0.0, "s2.delay": 0.0}
        fixed = fixed._replace(parameters=replace(fixed.parameters, lost))
    found = adapting_if_better(problem, candidate, fixed, sensors, 2, 0)
    assert (found.parameters.adapt.scale_time_constant > 0.0) == adapts
    assert found.parameters.adapt.lag_time_constant == 0.0
    assert found.fitted == problem.misfit(found.parameters)
    if adapts:
        assert found.unseen < ADAPTING_PAYS * fixed.unseen
    else:
        assert found == fixed


def test_the_largest_threshold_that_may_be_given_bounds_nothing(tuned: Tuned, unseen: Made) -> None:
    s2 = unseen.series.s2.copy()
    s2[20::40] += 30.0
    series = unseen.series._replace(s2=s2)
    off, largest = (
        values(fusion(replace(tuned.parameters, {"s2.outlier_threshold": each})), series)
        for each in (0.0, 1e6)
    )
    assert (off == largest).all()


def candidate_of(name: str, series: Series) -> Candidate:
    """Return a candidate for a recording with a truth."""
    return next(each for each in candidates_for(characterise(series)) if each.name == name)


def fitted_as(parameters: Parameters) -> FittedCandidate:
    """Return a fit with these parameters and made-up errors."""
    return FittedCandidate("bias", "", parameters, 1.0, 2.0, (2.0,) * BLOCKS)


def test_the_safety_net_does_not_fire_at_the_first_innovations_to_the_estimates_harm(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    time_s = np.arange(1000) * 0.04
    truth = np.sin(time_s) + np.sin(2.3 * time_s + 1.0)
    s2 = np.sin(time_s[::5] - 0.2) + np.sin(2.3 * (time_s[::5] - 0.2) + 1.0)
    stamps = START_NS + np.round(time_s * 1e9).astype(np.int64)
    series = Series(stamps, truth, stamps[::5], s2, np.arange(1000) // 5 + 1)
    fitted = {
        **{f"aggregator.weight.{each}": 0.0 for each in _WEIGHTS},
        "aggregator.difference.large": 1e9,
        "aggregator.difference.small": 5e8,
        "s1.bias_time_constant": 0.7,
        "s1.bias_prior": 0.0007,
        "s1.drift_time_constant": 80.0,
        "s2.noise": 0.0067,
        "s2.delay": 0.187,
        "s2.lag_time_constant": 0.022,
        "s2.outlier_threshold": OUTLIER_THRESHOLD,
    }
    parameters = replace(Parameters(), fitted)
    problem = Problem([series], truth, series.s2_known > 0, parameters)
    guarded = with_safety_net(problem, parameters)
    assert guarded.aggregator.difference.large < 10.0  # the net is still there
    assert problem.misfit(guarded) <= NO_WORSE * problem.misfit(parameters)
    known = np.abs(joined(parameters, [series]).innovation)
    undoubled = safety_net(float(np.nanmax(known)))["aggregator.difference.large"]
    doublings = round(np.log2(guarded.aggregator.difference.large / undoubled))
    assert doublings > 0
    for most, found in ((doublings, guarded), (doublings - 1, parameters)):
        monkeypatch.setattr(sys.modules[with_safety_net.__module__], "MOST_DOUBLINGS", most)
        assert with_safety_net(problem, parameters) == found


def test_garbage_of_s2_that_the_recording_lacks_does_little_harm(
    tuned: Tuned, unseen: Made
) -> None:
    s2 = unseen.series.s2.copy()
    s2[20::40] += 30.0
    assert tuned.parameters.s2.outlier_threshold == OUTLIER_THRESHOLD
    clean = rmse(run(fusion(tuned.parameters), unseen.series).value, unseen)
    value = run(fusion(tuned.parameters), unseen.series._replace(s2=s2)).value
    assert rmse(value, unseen) < 2.0 * clean


def test_a_perfect_s1_leaves_s1(patch: pytest.MonkeyPatch) -> None:
    series, truth = made(Sensors(bias=0.0, noise=0.0))
    result = tune(series, truth)
    assert result.chosen == "s1"
    assert result.error < 1e-15


def test_a_truth_that_is_elsewhere_is_refused(recording: Made) -> None:
    with pytest.raises(TuneError, match="got 0 samples of S1 within the span of the truth"):
        tune(recording.series, np.full_like(recording.truth, np.nan))


def candidate(name: str, unseen: float, surprise: float = 0.0) -> FittedCandidate:
    """Return a candidate with some errors."""
    return FittedCandidate(name, "", Parameters(), 0.0, unseen, (), surprise)


GOOD = {"s2": 2.0, "s1": 2.0, "aggregator": 1.5, "bias": 1.0, "slope": 1.0, "full": 1.0}


@pytest.mark.parametrize(
    ("errors", "s2_samples", "name"),
    [
        ({}, 100, "bias"),
        ({"full": 0.92}, 100, "bias"),
        ({"full": 0.9}, 100, "full"),
        ({"full": 0.9, "slope": 0.94}, 100, "slope"),
        ({"full": 0.8, "slope": 0.9}, 100, "full"),
        ({"aggregator": 0.92}, 100, "bias"),
        ({"aggregator": 0.8}, 100, "aggregator"),
        ({}, 49, "bias"),
        ({"aggregator": 0.1, "slope": 0.1, "full": 0.1}, 49, "bias"),
        ({"s1": 1.0}, 100, "s1"),
        ({"s2": 0.9, "s1": 1.0}, 100, "s2"),
    ],
)
def test_the_simplest_is_chosen_of_those_that_are_about_as_good(
    errors: dict[str, float], s2_samples: int, name: str
) -> None:
    candidates = [candidate(*each) for each in {**GOOD, **errors}.items()]
    assert chosen(candidates, s2_samples).name == name


def test_without_a_truth_the_rules_have_to_predict_s2_better() -> None:
    rest = [candidate(each, GOOD[each], 2.0) for each in ("s2", "s1", "aggregator", "bias")]
    for surprise, name in ((0.92, "slope"), (0.9, "full")):
        both = [candidate("slope", 1.0, 1.0), candidate("full", 1.0, surprise)]
        assert chosen([*rest, *both], 100, with_truth=False).name == name


def test_only_a_bias_with_a_slope_has_one_before_s2_has_spoken(tuned: Tuned) -> None:
    named = {each.name: each.parameters.s1 for each in tuned.candidates}
    assert named["slope"].drift_prior > 0.0
    assert named["full"].drift_prior > 0.0
    assert named["bias"].drift_prior == 0.0


@pytest.mark.parametrize(
    ("s1", "s2", "related", "name"),
    [
        (2.0, 2.0, False, "full"),
        (2.0, 1.0, False, "s2"),  # S2 foretells itself as well
        (2.0, 1.0, True, "full"),
        (0.84, 2.0, True, "s1"),  # S1 as it is, too
    ],
)
def test_without_a_truth_a_sensor_alone_is_chosen_by_how_it_foretells_s2(
    s1: float, s2: float, related: bool, name: str
) -> None:
    sensors = [candidate("s2", 0.0, s2), candidate("s1", 0.0, s1), candidate("aggregator", 0.0)]
    rest = [candidate(each, 1.0, 0.9) for each in ("bias", "slope")]
    full = candidate("full", 1.0, 0.81)
    assert chosen([*sensors, *rest, full], 100, False, related).name == name


def test_blocks_are_equal_parts_of_what_counts() -> None:
    counted = np.ones(103, np.bool_)
    counted[10:20] = False
    parts = parts_of(Problem([], np.zeros(103), counted, Parameters()))
    assert ((parts >= 0) == counted).all()
    assert (np.diff(parts[counted]) >= 0).all()
    sizes = np.bincount(parts[counted])
    assert sizes.size == BLOCKS
    assert set(sizes.tolist()) <= {23, 24}
    folds = folds_of(parts)
    assert (np.sum(folds, axis=0) == counted).all()
    assert [int(fold.sum()) for fold in folds] == sizes.tolist()


def test_of_many_recordings_every_eighth_is_left_out_at_a_time() -> None:
    short = [made(Sensors(), seconds=1.0).series] * 10
    n = 10 * short[0].s1.size
    counted = np.ones(n, np.bool_)
    parts = parts_of(Problem(short, np.zeros(n), counted, Parameters()))
    assert np.bincount(parts).tolist() == [25] * 10
    folds = folds_of(parts)
    assert [sorted(set(parts[fold].tolist())) for fold in folds[:3]] == [[0, 8], [1, 9], [2]]
    errors = errors_by_part(np.where(parts == 3, -2.0, 1.0), parts)
    assert errors.tolist() == [2.0 if k == 3 else 1.0 for k in range(10)]


def test_one_fit_serves_two_recordings_of_the_same_sensors(
    recording: Made, unseen: Made, patch: pytest.MonkeyPatch
) -> None:
    third = made(SENSORS, seed=2)
    tuned = tune_to([Trial(*recording), Trial(*unseen)], threads=2)
    for each, one in zip((recording, unseen), tuned.recordings, strict=True):
        value = run(fusion(tuned.parameters), each.series).value
        assert one.error == pytest.approx(rmse(value, each))
        assert one.error < 0.5 * min(one.baseline_errors["s1"], one.baseline_errors["s2"])
        assert one.unseen_error < 0.5 * min(one.baseline_errors["s1"], one.baseline_errors["s2"])
        assert one.oddities == ()
    assert tuned.error == pytest.approx(
        np.sqrt(np.mean([e.error**2 for e in tuned.recordings])), rel=0.01
    )
    ours = rmse(run(fusion(tuned.parameters), third.series).value, third)
    assert ours < 1.5 * max(each.error for each in tuned.recordings)


@pytest.mark.slow("another fit to two recordings")
def test_the_same_recording_twice_is_fitted_as_once(
    recording: Made, tuned: Tuned, patch: pytest.MonkeyPatch
) -> None:
    """Nothing of a recording is carried over into the next."""
    twice = tune_to([Trial(*recording), Trial(*recording)], threads=2)
    assert [each.fitted for each in twice.candidates[:2]] == pytest.approx(
        [each.fitted for each in tuned.candidates[:2]]
    )
    first, second = twice.recordings
    assert (first.error, first.before_error) == (second.error, second.before_error)
    assert first.before_error == tuned.before_error


def test_a_recording_of_other_sensors_is_named(recording: Made) -> None:
    usual = characterise(recording.series)
    quick, noisy, late, strange = (
        characterise(made(sensors, rate=rate).series)
        for sensors, rate in (
            (SENSORS, 50.0),
            (SENSORS._replace(noise=1.0), 25.0),
            (SENSORS._replace(delay=1.5), 25.0),
            (SENSORS, 25.0),
        )
    )
    typically = typical([usual, usual, quick])
    assert typically.s1_interval == usual.s1_interval
    assert typically.span == pytest.approx(2.0 * usual.span + quick.span)
    assert list(oddities(usual, typically)) == []
    assert list(oddities(quick, typically)) == [
        "S1 runs at 50 Hz, in the other recordings at 25 Hz",
        "S2 runs at 10 Hz, in the other recordings at 5 Hz",
    ]
    assert "S1's noise is" in "".join(oddities(noisy, typically))
    assert "S2 lags" in "".join(oddities(late, typically))
    unrelated = strange._replace(lag=strange.lag._replace(correlation=0.1), chance=0.3)
    assert "do not correlate in it" in "".join(oddities(unrelated, typically))


def test_the_recording_that_is_too_short_is_named(recording: Made) -> None:
    short = made(SENSORS, seconds=1.0)
    with pytest.raises(TuneError, match=r"^b: got 25 samples of S1, expected at least 50"):
        tune_to([Trial(*recording, "a"), Trial(*short, "b")])


def test_steps_without_effect_are_left_out(recording: Made) -> None:
    series, truth = recording
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    useless = {
        "s1.spike_threshold": 1e6,
        "s2.lag_time_constant": 0.5,
        "s1.drift_time_constant": 3.0,
    }
    unsure = characterise(series)._replace(lag=Lag(0.0, 0.2, 0.5))
    simple = simplified(problem, unsure, Parameters())
    assert simplified(problem, unsure, replace(Parameters(), useless)) == replace(
        Parameters(), {"aggregator.drift.large": simple.aggregator.drift.large}
    )
    long = replace(Parameters(), {"aggregator.rate.large": 1.23456789})
    assert rounded(problem, long).aggregator.rate.large == 1.235


def test_a_lag_takes_over_the_time_of_a_delay_that_is_left_out() -> None:
    series, truth = made(Sensors(lag=0.5), rate=100.0)
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    observer = {"s1.bias_time_constant": 1.0, "s2.lag_time_constant": 0.47, "s2.delay": 0.03}
    s2 = simplified(problem, characterise(series), replace(Parameters(), observer)).s2
    assert (s2.lag_time_constant, s2.delay) == (pytest.approx(0.5), 0.0)


def test_a_lag_that_is_sure_stays_also_where_the_recording_does_not_need_it() -> None:
    """While S1 is right, S2 is hardly looked at; later it may be all there is."""
    series, truth = made(Sensors(lag=0.5))
    series = series._replace(s1=truth + np.random.default_rng(3).normal(0.0, 0.01, truth.size))
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    observer = {"s1.bias_time_constant": 1e6, "s1.bias_prior": 1e-6, "s2.noise": 0.1}
    observer |= safety_net(1e3)
    fitted = replace(Parameters(), {**observer, "s2.lag_time_constant": 0.5})
    sensors = characterise(series)
    assert sensors.lag.correlation > SURE
    assert simplified(problem, sensors, fitted).s2.lag_time_constant == 0.5
    unsure = sensors._replace(lag=sensors.lag._replace(correlation=SURE - 0.01))
    assert simplified(problem, unsure, fitted).s2.lag_time_constant == 0.0


def test_the_standard_deviation_covers_errors_as_it_should(recording: Made) -> None:
    series, truth = recording
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    fitted = with_deviation(problem, Parameters(), 1.0)
    doubled = with_deviation(problem, Parameters(), 2.0)
    assert doubled.estimate.deviation_scale == pytest.approx(2.0 * fitted.estimate.deviation_scale)
    assert doubled.s1.noise == fitted.s1.noise <= 4.0 * error_of(problem, fitted)
    within = [_share_within(fitted, series, truth, times) for times in (1.0, 2.0)]
    assert min(np.subtract(within, WITHIN)) == pytest.approx(0.0, abs=2.0 / truth.size)


def test_few_large_errors_do_not_make_the_standard_deviation_too_large(recording: Made) -> None:
    series, truth = recording
    rare = truth.copy()
    rare[::50] += 100.0 * np.std(truth)
    problem = Problem([series], rare, series.s2_known > 0, Parameters())
    fitted = with_deviation(problem, Parameters(), 1.0)
    assert WITHIN[0] - 0.02 < _share_within(fitted, series, truth, 1.0) < 0.85


def _share_within(parameters: Parameters, series: Series, truth: Reals, times: float) -> float:
    trace = run(fusion(parameters), series)
    known = (series.s2_known > 0) & (trace.standard_deviation > 0.0)
    return float(np.mean((np.abs(trace.value - truth) < times * trace.standard_deviation)[known]))


def test_the_predictor_is_taken_only_where_it_helps() -> None:
    series, truth = made(Sensors(bias=0.0, noise=0.3), seconds=20.0)
    problem = Problem([series], truth, series.s2_known > 0, Parameters())
    alone = replace(Parameters(), {f"aggregator.weight.{each}": 1.0 for each in _WEIGHTS})
    with_it = with_predictor(problem, alone)
    assert error_of(problem, with_it) <= error_of(problem, alone)
    perfect = Problem([series._replace(s1=truth)], truth, series.s2_known > 0, Parameters())
    assert not with_predictor(perfect, alone).predictor.enabled


def test_few_samples_of_s2_do_not_switch_the_predictor_on(monkeypatch: pytest.MonkeyPatch) -> None:
    def with_it(problem: Problem, parameters: Parameters) -> Parameters:
        return replace(parameters, {"predictor.enabled": True})

    monkeypatch.setattr(sys.modules[tune.__module__], "with_predictor", with_it)
    given = replace(Parameters(), {"predictor.enabled": True})
    for seconds, enabled in ((9.0, False), (11.0, True)):
        series, truth = made(SENSORS, seconds=seconds)
        assert (series.s2.size >= ENOUGH_S2) == enabled
        assert tune(series, truth, given).parameters.predictor.enabled == enabled


_LAG = {"s2.lag_time_constant": 0.4, "s2.delay": 0.2}
_WEIGHTS = ("very_small", "small", "large", "very_large")


def test_a_fitted_lag_at_the_end_of_its_range_is_said_to_be_there(
    tuned: Tuned, recording: Made
) -> None:
    assert tuned.at_limit == ()
    assert "search range" not in outcome(tuned, "")
    space = candidate_of("bias", recording.series).spec.space
    longest = {each.name: each.high for each in space.axes}
    late = replace(tuned.parameters, {"s2.delay": longest["s2.delay"]})
    assert space.at_limit(late) == ("s2.delay",)
    text = outcome(tuned._replace(parameters=late, at_limit=space.at_limit(late)), "")
    assert f"the best value may be larger: s2.delay {longest['s2.delay']:.3g} s" in text
    assert "not measured" not in text


def test_json_and_text_agree_on_whether_the_lag_is_identifiable(tuned: Tuned) -> None:
    assert as_json(tuned, "rad")["characteristics"]["lag"]["identifiable"]
    one_way = tuned._replace(sensors=tuned.sensors._replace(one_way=1.0))
    assert not as_json(one_way, "rad")["characteristics"]["lag"]["identifiable"]
    assert "S2's lag is not identifiable" in "\n".join(described(one_way.sensors, "rad"))


def test_only_numbers_can_be_scaled_to_the_errors(
    recording: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    kalman = BASELINES["kalman"]
    wrong = kalman._replace(scaled=(*kalman.scaled, "kalman.biased"))
    monkeypatch.setattr(baselines, "BASELINES", {**BASELINES, "kalman": wrong})
    counted = recording.series.s2_known > 0
    with pytest.raises(ParameterError, match=r"kalman\.biased"):
        baselines.scaled_to_errors(
            BaselineParameters(), "kalman", [recording.series], recording.truth[counted], counted
        )


def test_few_samples_of_s2_without_a_truth_are_warned_of(tuned: Tuned) -> None:
    few = tuned._replace(s2_samples=ENOUGH_S2 - 1)
    assert "WARNING" not in outcome(tuned._replace(with_truth=False), "")
    assert "WARNING" not in outcome(few, "")
    for chosen_one in ("bias", "s1", "s2"):
        blind = few._replace(with_truth=False, chosen=chosen_one)
        assert "WARNING: 49 samples of S2 and no truth" in outcome(blind, "")


def test_a_fit_hardly_better_than_a_sensor_alone_is_warned_of(tuned: Tuned) -> None:
    poor = tuned._replace(error=0.6641, baseline_errors={"s1": 1.0, "s2": 0.7117})
    text = outcome(poor, "m/s")
    assert ". WARNING: this is hardly better than s2 alone (0.7117 m/s): run check; is S2" in text
    assert "WARNING: this is not better" in outcome(poor._replace(error=0.72), "m/s")
    assert "WARNING" not in outcome(poor._replace(error=0.64), "m/s")
    alone = outcome(poor._replace(chosen="s2"), "m/s")
    assert "s2 alone is as good as anything: you do not need the node" in alone
    assert "WARNING" not in alone
    behind = poor._replace(baseline_errors={"s1": 2.0, "s2": 2.0, "kalman": 0.4})
    assert "WARNING: the filter kalman is much better (0.4 m/s): run" in outcome(behind, "m/s")
    alone = outcome(poor._replace(baseline_errors={"s1": 2.0, "s2": 0.4}), "m/s")
    assert "not better than s2 alone" in alone
    assert alone.count("WARNING") == 1
    filtered = poor._replace(chosen="s1", baseline_errors={"s1": 1.0, "kalman_lag": 0.1})
    assert "no fit was better than s1 alone, but the filter kalman_lag is (0.1 m/s): use" in (
        outcome(filtered, "m/s")
    )


def test_s2_alone_for_want_of_common_motion_is_no_recommendation(tuned: Tuned) -> None:
    """Without a truth the error is then the distance of S2 from itself."""
    apart = tuned.sensors._replace(chance=1.0)
    errors = {"s1": 1.0, "s2": 0.0, "kalman": 0.1}
    alone = tuned._replace(
        sensors=apart, with_truth=False, chosen="s2", error=0.0, baseline_errors=errors
    )
    text = outcome(alone, "m/s")
    assert text.count("WARNING") == 1
    assert "WARNING: s2 alone was taken because s1 and s2 show no common motion" in text
    known = outcome(alone._replace(with_truth=True), "m/s")
    assert "s2 alone is as good as anything" in known


@pytest.mark.parametrize(("error", "is_said"), [(0.6, True), (0.4, False)])
def test_a_gain_without_common_motion_is_doubted(tuned: Tuned, error: float, is_said: bool) -> None:
    apart = tuned.sensors._replace(chance=1.0)
    errors = {"s1": 2.0, "s2": 1.0}
    text = outcome(tuned._replace(sensors=apart, error=error, baseline_errors=errors), "m/s")
    assert ("WARNING: s1 and s2 show no common motion" in text) is is_said
    related = tuned._replace(error=error, baseline_errors=errors)
    assert "WARNING" not in outcome(related, "m/s")


def test_what_cannot_be_seen_without_a_truth_is_said(tuned: Tuned) -> None:
    blind = tuned._replace(with_truth=False)
    assert "WARNING" not in outcome(blind, "m/s")
    fast = blind.sensors._replace(s2_interval=blind.sensors.s1_interval)
    assert "WARNING: S2 is as fast as S1" in outcome(blind._replace(sensors=fast), "m/s")
    worse = blind._replace(before_error=0.9 * blind.error)
    assert "WARNING: by this error what was given is better" in outcome(worse, "m/s")
    assert "WARNING" not in outcome(worse._replace(with_truth=True), "m/s")


def test_with_a_wrong_truth_no_other_advice_is_given(tuned: Tuned) -> None:
    errors = {"s1": 1.0, "s2": 0.7, "kalman": 0.1}
    wrong = tuned._replace(error=0.7, baseline_errors=errors, truth_is_wrong=True)
    text = outcome(wrong, "m/s")
    assert text.count("WARNING") == 1
    assert text.endswith(
        ". WARNING: a truth does not suit the sensors, so fit and errors mean nothing: correct it "
        "and tune again, or use --no-truth"
    )


@pytest.mark.parametrize(
    ("correlation", "words"),
    [
        (0.45, "this is a guess"),
        (0.54, "this is a guess"),
        (0.69, "this is a guess"),
        (0.75, "correlate by"),
    ],
)
def test_a_lag_of_little_correlation_is_not_printed_as_a_fact(
    tuned: Tuned, correlation: float, words: str
) -> None:
    lag = tuned.sensors.lag._replace(correlation=correlation)
    assert words in described(tuned.sensors._replace(lag=lag), "")[2]


def test_the_comments_tell_all(tuned: Tuned) -> None:
    text = "\n".join(comments(tuned, "rad", "a bag"))
    for part in ("Made by tune from a bag.", "S1: 25 Hz", "unseen", "(chosen)", "kalman_bias"):
        assert part in text
    assert "RMSE in rad against the truth" in text
    assert outcome(tuned, "rad") in text
