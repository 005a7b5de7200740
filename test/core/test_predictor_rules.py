# SPDX-License-Identifier: Apache-2.0
"""The rules of the predictor: inference, its gradients, and training on them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from reference import predictor as reference

from fuzzy_fusion_ros.core.predictor import Rules, descend, infer, train
from fuzzy_fusion_ros.parameters.fusion import PredictorParameters


def rules_of(rules: Sequence[reference.Rule]) -> Rules:
    """Return rules as the predictor takes them, in arrays for short."""
    return Rules(
        centres=[each for rule in rules for each in rule.centres],
        widths=[each for rule in rules for each in rule.widths],
        consequents=[rule.consequent for rule in rules],
    )


def random_rules(generator: np.random.Generator, inputs: int, rules: int) -> list[reference.Rule]:
    """Draw rules that overlap."""
    return [
        reference.Rule(
            centres=generator.normal(0.0, 0.5, inputs).tolist(),
            widths=generator.uniform(0.8, 2.0, inputs).tolist(),
            consequent=float(generator.normal()),
        )
        for _ in range(rules)
    ]


def same(rules: Rules, expected: Sequence[reference.Rule], tolerance: float) -> bool:
    """Compare rules, number by number."""
    return all(
        np.allclose(ours, theirs, rtol=tolerance, atol=tolerance)
        for ours, theirs in zip(rules, rules_of(expected), strict=True)
    )


@pytest.mark.parametrize(("inputs", "rules"), [(2, 1), (5, 3), (19, 5), (19, 20)])
def test_inference_is_that_of_the_reference(inputs: int, rules: int) -> None:
    generator = np.random.default_rng(inputs * rules)
    for _ in range(50):
        drawn = random_rules(generator, inputs, rules)
        x = generator.normal(0.0, 0.5, inputs)
        inference = infer(rules_of(drawn), x)
        assert inference.covered
        assert inference.output == pytest.approx(
            reference.infer(drawn, x.tolist()), rel=1e-9, abs=1e-12
        )
        shares = np.array(inference.strengths) / inference.total
        assert shares == pytest.approx(reference.shares(drawn, x.tolist()), rel=1e-9, abs=1e-12)


def test_the_squares_are_there() -> None:
    """Eqs. (4) and (5) lost them in print: a Gaussian, not a Laplacian."""
    rules = Rules(centres=[0.0, 2.0], widths=[1.0, 1.0], consequents=[0.0, 1.0])
    z = math.exp(-(0.5**2)), math.exp(-(1.5**2))
    assert infer(rules, np.array([0.5])).output == pytest.approx(z[1] / (z[0] + z[1]))


@pytest.mark.parametrize("distance", [5.0, 15.0, 26.0])
def test_far_from_every_rule_the_nearest_speaks(distance: float) -> None:
    """Each factor is a denormal or nothing; their ratio is not."""
    rules = [
        reference.Rule([0.0], [1.0], 3.0),
        reference.Rule([0.5], [1.0], -1.0),
    ]
    inference = infer(rules_of(rules), np.array([distance]))
    assert inference.covered
    assert inference.output == pytest.approx(reference.infer(rules, [distance]), rel=1e-9)


@pytest.mark.parametrize("distance", [27.0, 1e3, 1e50, -1e100])
def test_an_input_that_no_rule_covers_is_said_to_be_so(distance: float) -> None:
    rules = rules_of([reference.Rule([0.0], [1.0], 3.0), reference.Rule([0.5], [1.0], -1.0)])
    inference = infer(rules, np.array([distance]))
    assert not inference.covered
    assert (inference.output, inference.total) == (0.0, 0.0)


@pytest.mark.parametrize(("inputs", "rules"), [(2, 1), (4, 3), (19, 5)])
def test_the_gradients_are_those_of_the_loss(inputs: int, rules: int) -> None:
    """Eqs. (10)-(12) against central differences of (f - x_n)^2 / 2."""
    generator = np.random.default_rng(17 + inputs)
    for _ in range(10):
        drawn = random_rules(generator, inputs, rules)
        x, target = generator.normal(0.0, 0.5, inputs), float(generator.normal())
        before = rules_of(drawn)
        after = descend(1e-3, before, 0.0, infer(before, x), x, target)
        slopes = rules_of(reference.numeric_gradient(drawn, x.tolist(), target))
        for old, new, slope in zip(before, after, slopes, strict=True):
            assert np.subtract(old, new) / 1e-3 == pytest.approx(slope, rel=1e-4, abs=1e-8)


def test_a_step_is_that_of_the_reference_all_families_from_the_old_values() -> None:
    generator = np.random.default_rng(23)
    for _ in range(50):
        drawn = random_rules(generator, 19, 5)
        x, target = generator.normal(0.0, 0.5, 19), float(generator.normal())
        before = rules_of(drawn)
        after = descend(0.1, before, 0.0, infer(before, x), x, target)
        expected = reference.descend(drawn, x.tolist(), target, 0.1, narrowest=0.0)
        assert same(after, expected, 1e-9)


def test_a_step_leaves_the_rules_that_it_came_from() -> None:
    drawn = random_rules(np.random.default_rng(0), 4, 3)
    before = rules_of(drawn)
    x = np.full(4, 0.3)
    descend(0.3, before, 0.0, infer(before, x), x, 1.0)
    assert same(before, drawn, 0.0)


def test_without_cover_there_is_nothing_to_learn_from() -> None:
    before = rules_of([reference.Rule([0.0], [1.0], 3.0)])
    x = np.array([1e6])
    after = descend(0.3, before, 0.0, infer(before, x), x, 1.0)
    assert same(after, [reference.Rule([0.0], [1.0], 3.0)], 0.0)


@pytest.mark.parametrize("learning_rate", [1.0, 10.0, 1e6])
def test_widths_stay_above_zero(learning_rate: float) -> None:
    generator = np.random.default_rng(29)
    rules = rules_of(random_rules(generator, 4, 3))
    for _ in range(30):
        x = generator.normal(0.0, 1.0, 4)
        rules = descend(
            learning_rate, rules, 1e-3, infer(rules, x), x, float(generator.normal(0, 9))
        )
        assert min(rules.widths) >= 1e-3


def test_training_brings_the_error_below_the_threshold() -> None:
    drawn = random_rules(np.random.default_rng(31), 4, 3)
    x = np.array([0.1, -0.2, 0.3, 0.0])
    for threshold in (0.1, 1e-3, 1e-6):
        parameters = PredictorParameters(
            learning_rate=0.1, error_threshold=threshold, max_iterations=1000
        )
        rules = train(parameters, rules_of(drawn), 0.0, x, 0.7)
        assert abs(infer(rules, x).output - 0.7) < threshold


def test_training_stops_as_soon_as_the_error_is_below_the_threshold() -> None:
    drawn = random_rules(np.random.default_rng(31), 4, 3)
    x = np.array([0.1, -0.2, 0.3, 0.0])
    near = infer(rules_of(drawn), x).output + 0.01
    lax = PredictorParameters(error_threshold=0.02, max_iterations=1000)
    assert same(train(lax, rules_of(drawn), 0.0, x, near), drawn, 0.0)


def test_an_error_as_large_as_the_threshold_is_still_trained_on() -> None:
    alone = rules_of([reference.Rule([0.0], [1.0], 1.0), reference.Rule([99.0], [1.0], 2.0)])
    parameters = PredictorParameters(error_threshold=0.5, max_iterations=1, learning_rate=0.5)
    trained = train(parameters, alone, 0.0, np.array([0.0]), 1.5)
    assert trained.consequents == pytest.approx([1.25, 2.0])


def test_a_target_counts_as_no_further_away_than_the_rules_reach() -> None:
    rules = rules_of(random_rules(np.random.default_rng(43), 4, 3))
    x = np.array([0.1, -0.2, 0.3, 0.0])
    reach = np.ptp(rules.consequents)
    parameters = PredictorParameters(learning_rate=0.1)
    at_reach = train(parameters, rules, 0.0, x, infer(rules, x).output + reach)
    for beyond in (10.0 * reach, 1e100):
        trained = train(parameters, rules, 0.0, x, infer(rules, x).output + beyond)
        assert trained.consequents == pytest.approx(at_reach.consequents)


def test_no_step_is_longer_than_a_width() -> None:
    before = rules_of(random_rules(np.random.default_rng(47), 4, 3))
    after = descend(1e6, before, 1e-3, infer(before, np.zeros(4)), np.zeros(4), 1.0)
    moved = np.abs(np.subtract(after.centres, before.centres))
    assert (moved <= np.multiply(before.widths, 1.0 + 1e-12)).all()
    assert min(after.widths) >= 1e-3


@pytest.mark.parametrize("iterations", [0, 1, 7])
def test_training_takes_no_more_steps_than_it_may(iterations: int) -> None:
    drawn = random_rules(np.random.default_rng(37), 4, 3)
    x = [0.1, -0.2, 0.3, 0.0]
    expected: list[reference.Rule] = list(drawn)
    for _ in range(iterations):
        expected = reference.descend(expected, x, 0.5, 0.1, narrowest=0.0)
    parameters = PredictorParameters(
        error_threshold=0.0, max_iterations=iterations, learning_rate=0.1
    )
    assert same(train(parameters, rules_of(drawn), 0.0, np.array(x), 0.5), expected, 1e-9)
