# SPDX-License-Identifier: Apache-2.0
"""The benchmark, with its numbers written out."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

SAMPLE_TIME = 0.01
SAMPLES = 5000
GRAVITY, CART, POLE, HALF_LENGTH = 9.8, 1.0, 0.1, 0.5
S1_BIAS, S1_NOISE = -0.03, 0.05
S2_LAG, S2_NOISE = 0.2, 0.002


class Outcome(NamedTuple):
    """What a run leaves, sample by sample; the angle counts as pi/2 from a fall on."""

    angle: list[float]
    s1: list[float]
    s2: list[float]
    estimate: list[float]
    force: list[float]


def pendulum(state: Sequence[float], force: float) -> list[float]:
    """Return the derivative of (angle, rate)."""
    angle, rate = state
    total = CART + POLE
    numerator = (
        GRAVITY * math.sin(angle)
        - POLE * HALF_LENGTH * rate**2 * math.cos(angle) * math.sin(angle) / total
        - force * math.cos(angle) / total
    )
    denominator = HALF_LENGTH * (4 / 3 - POLE * math.cos(angle) ** 2 / total)
    return [rate, numerator / denominator]


def runge_kutta(
    slope: Callable[[Sequence[float]], list[float]], state: Sequence[float], h: float
) -> list[float]:
    """Return the state one classic fourth-order step later."""

    def along(direction: Sequence[float], length: float) -> list[float]:
        return [x + length * k for x, k in zip(state, direction, strict=True)]

    k1 = slope(state)
    k2 = slope(along(k1, h / 2))
    k3 = slope(along(k2, h / 2))
    k4 = slope(along(k3, h))
    return along(
        [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h
    )


class Controller:
    """Force from estimates: 40 x + 10 dx/dt, the latter through a low-pass of 0.02 s."""

    def __init__(self) -> None:
        self.last: float | None = None
        self.filtered = 0.0

    def force(self, estimate: float) -> float:
        """Take the next estimate."""
        bare = 0.0 if self.last is None else (estimate - self.last) / SAMPLE_TIME
        self.filtered += (1 - math.exp(-SAMPLE_TIME / 0.02)) * (bare - self.filtered)
        self.last = estimate
        return max(-100.0, min(100.0, 40 * estimate + 10 * self.filtered))


def run(
    estimate: Callable[[float, float], float],
    noise: Sequence[Sequence[float]],
    s2_lag: float = S2_LAG,
    s1_noise: float = S1_NOISE,
    s1_bias: float = S1_BIAS,
) -> Outcome:
    """Balance the pendulum for the length of ``noise``.

    Args:
        estimate: Gives the estimate from S1 and S2, sample after sample.
        noise: Standard normal numbers, two a sample: S1's and S2's.
        s2_lag: Time constant of S2, seconds.
        s1_noise: Standard deviation of S1's noise, rad.
        s1_bias: Bias of S1, rad.
    """
    outcome = Outcome([], [], [], [], [])
    state = [0.2, 0.0]
    lagged = state[0]
    controller = Controller()
    fallen = False
    for k, (noise_1, noise_2) in enumerate(noise):
        fallen = fallen or abs(state[0]) >= math.pi / 2
        if fallen:
            outcome.angle.append(math.pi / 2)
            continue
        s1 = state[0] + s1_bias + s1_noise * noise_1
        s2 = lagged + S2_NOISE * noise_2
        guess = estimate(s1, s2)
        force = controller.force(guess)
        for values, value in zip(outcome, (state[0], s1, s2, guess, force), strict=True):
            values.append(value)
        push = -5.0 if 2500 <= k < 2510 else 0.0
        total = force + push
        state = runge_kutta(functools.partial(pendulum, force=total), state, SAMPLE_TIME)
        lagged += (1 - math.exp(-SAMPLE_TIME / s2_lag)) * (state[0] - lagged)
    return outcome


def integral_of_error(angle: Sequence[float]) -> float:
    """Return IAE, rad s."""
    return math.fsum(abs(x) * SAMPLE_TIME for x in angle)


def integral_of_timed_error(angle: Sequence[float]) -> float:
    """Return ITAE, rad s^2."""
    return math.fsum(k * SAMPLE_TIME * abs(x) * SAMPLE_TIME for k, x in enumerate(angle))
