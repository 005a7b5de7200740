# SPDX-License-Identifier: Apache-2.0
"""Fuzzy predictor: inference and its gradients, in loops over plain numbers.

A rule is a list of centres, a list of widths (one of each an input) and a consequent.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple


class Rule(NamedTuple):
    """One rule: x-bar and sigma of each input, and y-bar."""

    centres: list[float]
    widths: list[float]
    consequent: float


def exponent(rule: Rule, inputs: Sequence[float]) -> float:
    """Return the logarithm of z: the product of Gaussians is a sum there."""
    return -math.fsum(
        ((x - centre) / width) ** 2
        for x, centre, width in zip(inputs, rule.centres, rule.widths, strict=True)
    )


def shares(rules: Sequence[Rule], inputs: Sequence[float]) -> list[float]:
    """Return z / (sum of z) of each rule, by way of the logarithm of the sum."""
    exponents = [exponent(rule, inputs) for rule in rules]
    top = max(exponents)
    log_sum = top + math.log(math.fsum(math.exp(e - top) for e in exponents))
    return [math.exp(e - log_sum) for e in exponents]


def infer(rules: Sequence[Rule], inputs: Sequence[float]) -> float:
    """Return f: the centre average of the consequents."""
    return math.fsum(
        rule.consequent * share for rule, share in zip(rules, shares(rules, inputs), strict=True)
    )


def loss(rules: Sequence[Rule], inputs: Sequence[float], target: float) -> float:
    """Return half the squared error, which the training descends."""
    return (infer(rules, inputs) - target) ** 2 / 2


def descend(
    rules: Sequence[Rule],
    inputs: Sequence[float],
    target: float,
    learning_rate: float,
    narrowest: float,
) -> list[Rule]:
    """Return the rules after one step of all three families, each from the old values."""
    f = infer(rules, inputs)
    error = f - target
    after = []
    for rule, share in zip(rules, shares(rules, inputs), strict=True):
        lever = error * share * (rule.consequent - f)
        centres, widths = [], []
        for x, centre, width in zip(inputs, rule.centres, rule.widths, strict=True):
            centres.append(centre - learning_rate * lever * 2 * (x - centre) / width**2)
            moved = width - learning_rate * lever * 2 * (x - centre) ** 2 / width**3
            widths.append(max(moved, narrowest))
        after.append(Rule(centres, widths, rule.consequent - learning_rate * error * share))
    return after


def numeric_gradient(
    rules: Sequence[Rule], inputs: Sequence[float], target: float, step: float = 1e-6
) -> list[Rule]:
    """Return the derivatives of the loss by central differences, in the shape of the rules."""
    numbers = unravelled(rules)
    slopes = []
    for position in range(len(numbers)):
        below, above = list(numbers), list(numbers)
        below[position] -= step
        above[position] += step
        rise = loss(ravelled(above, len(inputs)), inputs, target)
        rise -= loss(ravelled(below, len(inputs)), inputs, target)
        slopes.append(rise / (2 * step))
    return ravelled(slopes, len(inputs))


def unravelled(rules: Sequence[Rule]) -> list[float]:
    """Return all numbers of the rules in one list."""
    return [x for rule in rules for x in (*rule.centres, *rule.widths, rule.consequent)]


def ravelled(numbers: Sequence[float], inputs: int) -> list[Rule]:
    """Return the rules that a list of numbers holds."""
    size = 2 * inputs + 1
    each = [numbers[start : start + size] for start in range(0, len(numbers), size)]
    return [Rule(list(n[:inputs]), list(n[inputs:-1]), n[-1]) for n in each]
