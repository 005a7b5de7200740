# SPDX-License-Identifier: Apache-2.0
"""The fuzzy predictor (FP), eqs. (2)-(13): trained online by gradient descent.

Inputs and output are taken relative to the newest estimate, so the rules do not depend on where
the signal is, and the first rules are straight lines through it: *falling*, *steady*, *rising*.

All of it is loops over plain numbers, for compilers: numba takes the lists as arrays, mypyc as
vectors. Lists that go in are left as they were. The centres and widths of one rule stand together,
one for each input; inputs are the n - 1 previous estimates, oldest first.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from fuzzy_fusion_ros.core.gate import NO_PREDICTION, Prediction
from fuzzy_fusion_ros.core.numerics import bounded, clamped
from fuzzy_fusion_ros.parameters.fusion import PredictorParameters

COMPILED = not __file__.endswith(".py")
"""Compiled ahead of time by mypyc, which holds this for true."""

if COMPILED:
    from librt.vecs import vec  # a list holds a Python object for each number

    Numbers = vec[float]
else:
    Numbers = list[float]

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
        centres: x-bar of every input, rule by rule, unit of the signal.
        widths: sigma of every input, rule by rule, above 0, unit of the signal.
        consequents: y-bar of each rule, unit of the signal.
    """

    centres: Numbers
    widths: Numbers
    consequents: Numbers


class Inference(NamedTuple):
    """Eq. (4) at one input.

    Attributes:
        covered: Whether any rule covers the input; if not, the rest is 0.
        output: f, unit of the signal.
        strengths: z of each rule, scaled so that the largest is 1.
        total: b, their sum.
    """

    covered: bool
    output: float
    strengths: Numbers
    total: float


class Predictor(NamedTuple):
    """What the predictor keeps.

    Attributes:
        filled: How many estimates of ``history`` are there.
        history: The last n estimates, oldest first.
        stamp_ns: Stamp of the newest.
        step_ns: Time between the newest two, 0 until there are two.
        rules: The rules; only meaningful once the history is filled.
        narrowest: Floor of the widths, unit of the signal.
        increment: f(x_2 .. x_n), the next step's predicted increment.
        ready: Whether ``increment`` is a prediction.
    """

    filled: int
    history: Numbers
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
        history=Numbers([0.0] * samples),
        stamp_ns=0,
        step_ns=0,
        rules=Rules(
            centres=Numbers([0.0] * ((samples - 1) * rules)),
            widths=Numbers([1.0] * ((samples - 1) * rules)),
            consequents=Numbers([0.0] * rules),
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
    before = state.filled
    if state.step_ns > 0 and step_ns > LONGEST_STEP * state.step_ns:
        before = 0
    n = len(state.history)
    history = copied(state.history)
    for i in range(n - 1):
        history[i] = state.history[i + 1]
    history[n - 1] = bounded(estimate)
    filled = min(before + 1, n)
    rules = state.rules
    narrowest = state.narrowest
    increment = 0.0
    ready = False
    if filled == n:
        if before < filled:
            rules = straight_lines(parameters, rules, step_ns * 1e-9)
            narrowest = NARROWEST * rules.widths[0]
        origin = history[n - 2]
        rules = train(
            parameters, rules, narrowest, relative(history[:-1], origin), history[n - 1] - origin
        )
        ahead = infer(rules, relative(history[1:], history[n - 1]))
        increment = ahead.output
        ready = ahead.covered
    return Predictor(
        filled=filled,
        history=history,
        stamp_ns=stamp_ns,
        step_ns=step_ns if before > 0 else 0,
        rules=rules,
        narrowest=narrowest,
        increment=increment,
        ready=ready,
    )


def copied(values: Numbers) -> Numbers:
    """Return a copy of a list or a vector; for arrays, numpy's takes the place of this."""
    return values[:]


def relative(values: Numbers, origin: float) -> Numbers:
    """Return the distances of values from an origin."""
    distances = copied(values)
    for i in range(len(values)):
        distances[i] = values[i] - origin
    return distances


def straight_lines(parameters: PredictorParameters, rules: Rules, step: float) -> Rules:
    """Return the first rules: straight lines of evenly spread slopes through the newest estimate.

    Rule l says: if the signal has followed the line of slope ``s_l``, it continues along it for
    ``lead`` steps. Slopes reach from ``-slope`` to ``slope``. With one width for all inputs the
    rules weigh an estimate by its age, as a least-squares fit of a line does.

    Args:
        parameters: Of the predictor.
        rules: As many rules of as many inputs.
        step: Time between estimates, seconds.
    """
    centres = copied(rules.centres)
    widths = copied(rules.widths)
    consequents = copied(rules.consequents)
    n = len(consequents)
    inputs = len(centres) // n
    spacing = 2.0 * parameters.slope / float(n - 1)
    width = SPREAD * spacing * float(inputs - 1) * step
    for rule in range(n):
        slope = float(rule) * spacing - parameters.slope
        consequents[rule] = slope * parameters.lead * step
        for i in range(inputs):
            age = float(inputs - 1 - i) * step
            centres[rule * inputs + i] = -slope * age
            widths[rule * inputs + i] = width
    return Rules(centres=centres, widths=widths, consequents=consequents)


def infer(rules: Rules, inputs: Numbers) -> Inference:
    """Eqs. (4)-(7) with the square restored; the largest exponent is taken out of a / b."""
    centres = rules.centres
    widths = rules.widths
    consequents = rules.consequents
    strengths = copied(consequents)
    largest = -math.inf
    k = 0
    for rule in range(len(consequents)):
        exponent = 0.0
        for x in inputs:
            scaled = (x - centres[k]) / widths[k]
            exponent -= scaled * scaled
            k += 1
        strengths[rule] = exponent
        largest = max(largest, exponent)
    a = 0.0
    b = 0.0
    for rule in range(len(consequents)):
        strength = math.exp(strengths[rule] - largest) if largest > NOT_COVERED else 0.0
        strengths[rule] = strength
        a += consequents[rule] * strength
        b += strength
    covered = b > 0.0
    return Inference(
        covered=covered, output=a / b if covered else 0.0, strengths=strengths, total=b
    )


def train(
    parameters: PredictorParameters,
    rules: Rules,
    narrowest: float,
    inputs: Numbers,
    target: float,
) -> Rules:
    """Eq. (3): gradient descent until the error is below the threshold or the bound is met.

    A target counts as no further away than the range of what the rules can say, so that an
    outlier does not wreck them.
    """
    for _ in range(parameters.max_iterations):
        inference = infer(rules, inputs)
        if abs(inference.output - target) < parameters.error_threshold:
            break
        low = high = rules.consequents[0]
        for consequent in rules.consequents:
            low = min(low, consequent)
            high = max(high, consequent)
        reach = high - low
        within = clamped(target, inference.output - reach, inference.output + reach)
        rules = descend(parameters.learning_rate, rules, narrowest, inference, inputs, within)
    return rules


def descend(
    learning_rate: float,
    rules: Rules,
    narrowest: float,
    inference: Inference,
    inputs: Numbers,
    target: float,
) -> Rules:
    """Eqs. (10)-(12): one step of all three families, each from the values before the step.

    No centre or width moves by more than a width. Without cover there is nothing to learn from.
    """
    if not inference.covered:
        return rules
    centres = copied(rules.centres)
    widths = copied(rules.widths)
    consequents = copied(rules.consequents)
    strengths = inference.strengths
    output = inference.output
    share = learning_rate * (output - target) / inference.total
    k = 0
    for rule in range(len(consequents)):
        consequent = consequents[rule]
        common = share * strengths[rule]
        pull = common * (consequent - output) * 2.0
        consequents[rule] = consequent - common
        for x in inputs:
            centre = centres[k]
            width = widths[k]
            distance = x - centre
            to_centre = pull * distance / (width * width)
            to_width = to_centre * distance / width
            if not -width <= to_centre <= width:  # calls would cost most of the time of this
                to_centre = clamped(to_centre, -width, width)
            if not -width <= to_width <= width:
                to_width = clamped(to_width, -width, width)
            centres[k] = centre - to_centre
            narrower = width - to_width
            widths[k] = narrowest if narrower < narrowest else narrower
            k += 1
    return Rules(centres=centres, widths=widths, consequents=consequents)
