# SPDX-License-Identifier: Apache-2.0
"""Random parameters and samples, and all that the method says to them, to the last bit.

Run as a program it prints a line for each step, so that two builds of the method can be compared.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any, cast

import numpy as np

from fuzzy_fusion_ros.core import estimator
from fuzzy_fusion_ros.parameters.errors import ParameterError
from fuzzy_fusion_ros.parameters.fusion import Parameters
from fuzzy_fusion_ros.parameters.group import descriptors, numbers, replace

WALKS = 60
STEPS = 60
START_NS = 1_700_000_000_000_000_000
ODD = (math.nan, math.inf, -math.inf, 1e300, -0.0, 5e-324, -113.0)
"""Values that compilers trip over; the last stands for an error in what mypyc makes."""


def random_parameters(chance: random.Random) -> Parameters:
    """Draw numbers and switches: some as they are, some off, some anywhere in their range."""
    changes: dict[str, object] = {"predictor.enabled": True}
    for name, descriptor, default in descriptors(Parameters):
        if descriptor.kind is float and not descriptor.fixed and chance.random() < 0.5:
            anywhere = chance.random() < 0.7
            number = 10 ** chance.uniform(-4.0, 2.0) if anywhere else float(cast(float, default))
            changes[name] = min(max(number, descriptor.low), descriptor.high)
    changes["predictor.samples"] = chance.randint(3, 25)
    changes["predictor.rules"] = chance.randint(2, 6)
    changes["predictor.max_iterations"] = chance.choice((0, 1, 1, 4))
    try:
        return replace(Parameters(), changes)
    except ParameterError:  # a combination that is not allowed
        return random_parameters(chance)


def plain(value: Any) -> Any:
    """Return a state without arrays, which would be printed rounded, and vectors."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, tuple):
        return tuple(map(plain, value))
    return list(value) if hasattr(value, "__len__") else value


def walk(seed: int) -> Iterator[str]:
    """Yield what the method says to each sample, or the error that it raises."""
    chance = random.Random(seed)
    parameters = random_parameters(chance)
    taken = numbers(parameters) if seed % 2 else parameters
    state = estimator.initial_state(parameters)
    stamp_ns = START_NS
    signal = 0.0
    for k in range(STEPS):
        signal += chance.gauss(0.0, 0.05)
        step_ns = 9_123_457_000 if chance.random() < 0.02 else chance.randint(9_000_000, 11_000_000)
        s1 = signal + chance.gauss(0.3, 0.02) + (5.0 if chance.random() < 0.05 else 0.0)
        if seed % 5 == 0 and chance.random() < 0.1:
            s1 = chance.choice(ODD)
            step_ns *= chance.choice((1, 0, -1))
        stamp_ns += step_ns
        try:
            if k % 4 == 2:
                observed_ns = stamp_ns - chance.choice((0, 300_000_000))
                state = estimator.observe_s2(taken, state, observed_ns, signal)
                yield repr(estimator.without_s1(taken, state, observed_ns))
            estimate, state = estimator.update(taken, state, stamp_ns, s1)
            yield repr(plain((estimate, state)))
        except (ArithmeticError, ValueError) as error:
            yield f"{type(error).__name__}: {error}"


if __name__ == "__main__":
    for seed in range(WALKS):
        for line in walk(seed):
            print(line)
