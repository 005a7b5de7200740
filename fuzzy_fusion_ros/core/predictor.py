"""The fuzzy predictor (FP), eqs. (2)-(13): trained online by gradient descent, method § 3.

Inputs and output are taken relative to the newest estimate, so the rules do not depend on where
the signal is, and the first rules are straight lines through it: *falling*, *steady*, *rising*.

Arrays are ``(inputs, rules)``, inputs being the n - 1 previous estimates, oldest first. Sums
over inputs run along the first axis and sums over rules in a loop, one after the other, so that
compiled and interpreted runs agree bit for bit.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction
from fuzzy_fusion_ros.core.numerics import bounded, clamped
from fuzzy_fusion_ros.parameters.fusion import PredictorParameters

Array = NDArray[np.float64]

NOT_COVERED = -700.0
"""Exponent below which no rule covers an input: its Gaussian is at the smallest normal number."""

LONGEST_STEP = 3
"""A step longer than this many of the last is a gap: the history restarts."""

SPREAD = 0.6
"""Width of the first rules as a share of the distance between them at the oldest estimate."""

NARROWEST = 1e-3
"""Floor of a width as a share of the first rules'."""


class Rules(NamedTuple):
    """The trained parameters of eq. (4).

    Attributes:
        centres: x-bar, shape (inputs, rules), unit of the signal.
        widths: sigma, shape (inputs, rules), above 0, unit of the signal.
        consequents: y-bar, shape (rules,), unit of the signal.
    """

    centres: Array
    widths: Array
    consequents: Array


class Inference(NamedTuple):
    """Eq. (4) at one input.

    Attributes:
        covered: Whether any rule covers the input; if not, the rest is 0.
        output: f, unit of the signal.
        strengths: z of each rule, scaled so that the largest is 1, shape (rules,).
        total: b, their sum.
    """

    covered: bool
    output: float
    strengths: Array
    total: float


class Predictor(NamedTuple):
    """What the predictor keeps.

    Attributes:
        filled: How many estimates of ``history`` are there.
        history: The last n estimates, oldest first, shape (n,).
        stamp_ns: Stamp of the newest.
        step_ns: Time between the newest two, 0 until there are two.
        rules: The rules; only meaningful once the history is filled.
        narrowest: Floor of the widths, unit of the signal.
        increment: f(x_2 .. x_n), the next step's predicted increment.
        ready: Whether ``increment`` is a prediction.
    """

    filled: int
    history: Array
    stamp_ns: int
    step_ns: int
    rules: Rules
    narrowest: float
    increment: float
    ready: bool


def untrained(samples: int, rules: int) -> Predictor:
    """Return the state before any estimate, for n = ``samples``."""
    return Predictor(
        filled=0,
        history=np.zeros(samples),
        stamp_ns=0,
        step_ns=0,
        rules=Rules(
            centres=np.zeros((samples - 1, rules)),
            widths=np.ones((samples - 1, rules)),
            consequents=np.zeros(rules),
        ),
        narrowest=0.0,
        increment=0.0,
        ready=False,
    )


def prediction_at(parameters: PredictorParameters, state: Predictor, stamp_ns: int) -> Prediction:
    """Eq. (13): the prediction for ``stamp_ns``, made when the last estimate came in.

    The predicted increment is for a step as long as the last; it is stretched to the real one.
    """
    elapsed_ns = stamp_ns - state.stamp_ns
    if not parameters.enabled or not state.ready or elapsed_ns > LONGEST_STEP * state.step_ns:
        return NO_PREDICTION
    stretch = elapsed_ns / state.step_ns
    return Prediction(exists=True, value=state.history[-1] + stretch * state.increment)


def learn(
    parameters: PredictorParameters, state: Predictor, stamp_ns: int, estimate: float
) -> Predictor:
    """Eqs. (2), (3), (13): take the final estimate, train on it, predict the next.

    Args:
        parameters: Of the predictor.
        state: The state after the last estimate.
        stamp_ns: Stamp of the estimate, later than that of the last.
        estimate: The final estimate, finite.
    """
    if not parameters.enabled:
        return state
    step_ns = stamp_ns - state.stamp_ns
    if state.step_ns > 0 and step_ns > LONGEST_STEP * state.step_ns:
        state = untrained(state.history.size, state.rules.consequents.size)
    history = np.empty_like(state.history)
    history[:-1] = state.history[1:]
    history[-1] = bounded(estimate)
    filled = min(state.filled + 1, history.size)
    rules = state.rules
    narrowest = state.narrowest
    increment = 0.0
    ready = False
    if filled == history.size:
        if state.filled < filled:
            rules = straight_lines(parameters, history.size - 1, step_ns * 1e-9)
            narrowest = NARROWEST * rules.widths[0, 0]
        rules = train(
            parameters, rules, narrowest, history[:-1] - history[-2], history[-1] - history[-2]
        )
        ahead = infer(rules, history[1:] - history[-1])
        increment = ahead.output
        ready = ahead.covered
    return Predictor(
        filled=filled,
        history=history,
        stamp_ns=stamp_ns,
        step_ns=step_ns if state.filled > 0 else 0,
        rules=rules,
        narrowest=narrowest,
        increment=increment,
        ready=ready,
    )


def straight_lines(parameters: PredictorParameters, inputs: int, step: float) -> Rules:
    """Return the first rules: straight lines of evenly spread slopes through the newest estimate.

    Rule l says: if the signal has come along the line of slope ``s_l``, it goes on along it for
    ``lead`` steps. Slopes reach from ``-slope`` to ``slope``. With one width for all inputs the
    rules weigh an estimate by its age, as a least-squares fit of a line does.

    Args:
        parameters: Of the predictor.
        inputs: n - 1.
        step: Time between estimates, seconds.
    """
    n = parameters.rules
    spacing = 2.0 * parameters.slope / (n - 1)
    width = SPREAD * spacing * (inputs - 1) * step
    centres = np.zeros((inputs, n))
    consequents = np.zeros(n)
    for rule in range(n):
        slope = rule * spacing - parameters.slope
        consequents[rule] = slope * parameters.lead * step
        for i in range(inputs):
            age = (inputs - 1 - i) * step
            centres[i, rule] = -slope * age
    return Rules(centres=centres, widths=np.full((inputs, n), width), consequents=consequents)


def infer(rules: Rules, inputs: Array) -> Inference:
    """Eqs. (4)-(7) with the square restored; the largest exponent is taken out of a / b."""
    scaled = (inputs.reshape(-1, 1) - rules.centres) / rules.widths
    exponents = -(scaled * scaled).sum(axis=0)
    largest = exponents[0]
    for exponent in exponents:
        largest = max(largest, exponent)
    strengths = np.zeros_like(exponents)
    a = 0.0
    b = 0.0
    if largest > NOT_COVERED:
        for rule in range(exponents.size):
            strengths[rule] = math.exp(exponents[rule] - largest)
            a += rules.consequents[rule] * strengths[rule]
            b += strengths[rule]
    covered = b > 0.0
    return Inference(
        covered=covered, output=a / b if covered else 0.0, strengths=strengths, total=b
    )


def train(
    parameters: PredictorParameters, rules: Rules, narrowest: float, inputs: Array, target: float
) -> Rules:
    """Eq. (3): gradient descent until the error is below the threshold or the bound is met.

    A target counts as no further away than the range of what the rules can say, so that an
    outlier does not wreck them.
    """
    for _ in range(parameters.max_iterations):
        inference = infer(rules, inputs)
        if abs(inference.output - target) < parameters.error_threshold:
            break
        reach = rules.consequents.max() - rules.consequents.min()
        within = clamped(target, inference.output - reach, inference.output + reach)
        rules = descend(parameters.learning_rate, rules, narrowest, inference, inputs, within)
    return rules


def descend(
    learning_rate: float,
    rules: Rules,
    narrowest: float,
    inference: Inference,
    inputs: Array,
    target: float,
) -> Rules:
    """Eqs. (10)-(12): one step of all three families, each from the values before the step.

    No centre or width moves by more than a width. Without cover there is nothing to learn from.
    """
    if not inference.covered:
        return rules
    error = inference.output - target
    common = learning_rate * error / inference.total * inference.strengths
    pull = common * (rules.consequents - inference.output)
    distance = inputs.reshape(-1, 1) - rules.centres
    to_centres = pull * 2.0 * distance / (rules.widths * rules.widths)
    to_widths = to_centres * distance / rules.widths
    return Rules(
        centres=rules.centres - limited(to_centres, rules.widths),
        widths=np.maximum(rules.widths - limited(to_widths, rules.widths), narrowest),
        consequents=rules.consequents - common,
    )


def limited(step: Array, limit: Array) -> Array:
    """Return a step within its limit, element by element."""
    return np.minimum(np.maximum(step, -limit), limit)
