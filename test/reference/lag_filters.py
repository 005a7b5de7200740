# SPDX-License-Identifier: Apache-2.0
"""The baselines that model S2's lag, in matrices and whole histories."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fuzzy_fusion_ros.baselines import ErrorStateParameters, KalmanLagParameters

Array = NDArray[np.float64]

NU = 4.0
"""Degrees of freedom of Student's t-distribution."""


def share(dt: float, time_constant: float) -> float:
    """Return how far a first-order lag goes in ``dt`` seconds."""
    return 1.0 - float(np.exp(-dt / time_constant)) if time_constant > 0.0 else 1.0


def corrected(x: Array, p: Array, h: Array, value: float, variance: float) -> tuple[Array, Array]:
    """Correct mean and covariance by a measurement of ``h x`` with Student's noise."""
    innovation = value - float(h @ x)
    weight = (NU + 1.0) / (NU + innovation**2 / (float(h @ p @ h) + variance))
    noise = variance / weight
    gain = p @ h / (float(h @ p @ h) + noise)
    left = np.eye(x.size) - np.outer(gain, h)
    return x + gain * innovation, left @ p @ left.T + noise * np.outer(gain, gain)


class MatrixKalmanLag:
    """Signal, velocity, bias and two lags; starts at the first sample of S2."""

    S1 = np.array([1.0, 0.0, 1.0, 0.0, 0.0])
    S2 = np.array([0.0, 0.0, 0.0, 0.0, 1.0])

    def __init__(self, parameters: KalmanLagParameters) -> None:
        self._it = parameters
        self._x = np.zeros(5)
        self._p = np.zeros((5, 5))
        self._s2: list[tuple[float, float]] = []
        self._time_s = 0.0

    @property
    def signal(self) -> float:
        """Mean of the signal."""
        return float(self._x[0])

    @property
    def variance(self) -> float:
        """Variance of the signal."""
        return float(self._p[0, 0])

    def take_s2(self, time_s: float, value: float) -> None:
        """Take a sample of S2."""
        it = self._it
        if not self._s2:
            self._x[[0, 3, 4]] = value
            self._p[np.ix_([0, 3, 4], [0, 3, 4])] = it.s2_noise**2
            self._p[1, 1] = it.velocity_deviation**2
            self._p[2, 2] = it.bias_deviation**2
            self._time_s = time_s
        else:
            before_s, before = self._s2[-1]
            rate = (value - before) / (time_s - before_s)
            variance = it.s2_noise**2 + (it.s2_motion_noise * rate) ** 2
            self._predict(time_s)
            self._x, self._p = corrected(self._x, self._p, self.S2, value, variance)
        self._s2.append((time_s, value))

    def take_s1(self, time_s: float, value: float) -> None:
        """Take a sample of S1."""
        self._predict(time_s)
        variance = self._it.s1_noise**2
        self._x, self._p = corrected(self._x, self._p, self.S1, value, variance)

    def _predict(self, time_s: float) -> None:
        it, dt = self._it, max(time_s - self._time_s, 0.0)
        lost = share(dt, it.velocity_time_constant)
        move, first, second = np.eye(5), np.eye(5), np.eye(5)
        move[0, 1], move[1, 1] = it.velocity_time_constant * lost, 1.0 - lost
        h, k = share(dt, it.lag_time_constant), share(dt, it.second_lag_time_constant)
        first[3, [0, 3]] = h, 1.0 - h
        second[4, [3, 4]] = k, 1.0 - k
        f = second @ first @ move
        q = np.diag(
            [
                it.process_noise**2 * dt,
                it.velocity_deviation**2 * (1.0 - (1.0 - lost) ** 2),
                it.bias_noise**2 * dt,
                0.0,
                0.0,
            ]
        )
        self._x, self._p = f @ self._x, f @ self._p @ f.T + q
        self._time_s = max(self._time_s, time_s)


class MatrixTrend:
    """A value and its slope."""

    H = np.array([1.0, 0.0])

    def __init__(self, walk: float, deviation: float, time_constant: float) -> None:
        self._walk, self._deviation, self._time_constant = walk, deviation, time_constant
        self.x = np.zeros(2)
        self.p = np.diag([0.0, deviation**2])

    def predict(self, dt: float) -> None:
        """Let ``dt`` seconds pass."""
        dt = max(dt, 0.0)
        lost = share(dt, self._time_constant)
        f = np.array([[1.0, self._time_constant * lost], [0.0, 1.0 - lost]])
        q = np.diag([self._walk**2 * dt, self._deviation**2 * (1.0 - (1.0 - lost) ** 2)])
        self.x, self.p = f @ self.x, f @ self.p @ f.T + q

    def correct(self, value: float, variance: float) -> None:
        """Take a measurement of the value."""
        self.x, self.p = corrected(self.x, self.p, self.H, value, variance)


class MatrixErrorState:
    """S1 minus its bias, both with a slope; remembers all of S1 for the delay."""

    def __init__(self, parameters: ErrorStateParameters) -> None:
        it = self._it = parameters
        self._s1 = MatrixTrend(it.process_noise, it.velocity_deviation, it.velocity_time_constant)
        self._bias = MatrixTrend(it.bias_noise, it.slope_deviation, it.slope_time_constant)
        self._bias.p[0, 0] = it.bias_deviation**2
        self._times: list[float] = []
        self._lagged: list[float] = []
        self._bias_s = 0.0
        self._s2: list[tuple[float, float]] = []

    @property
    def signal(self) -> float:
        """S1 after the low-pass, minus its bias."""
        return float(self._s1.x[0] - self._bias.x[0])

    @property
    def variance(self) -> float:
        """Variance of both, which are taken as independent."""
        return float(self._s1.p[0, 0] + self._bias.p[0, 0])

    def take_s2(self, time_s: float, value: float) -> None:
        """Take a sample of S2."""
        it = self._it
        if self._times:
            rate = 0.0
            if self._s2:
                rate = (value - self._s2[-1][1]) / (time_s - self._s2[-1][0])
            seen = float(np.interp(time_s - it.delay, self._times, self._lagged))
            self._predict_bias(time_s)
            self._bias.correct(seen - value, it.s2_noise**2 + (it.s2_motion_noise * rate) ** 2)
        self._s2.append((time_s, value))

    def take_s1(self, time_s: float, value: float) -> None:
        """Take a sample of S1."""
        it = self._it
        if not self._times:
            self._s1.x[0], self._s1.p[0, 0] = value, it.s1_noise**2
            lagged, self._bias_s = value, time_s
            if self._s2:
                self._bias.correct(value - self._s2[-1][1], it.s2_noise**2)
        else:
            dt = time_s - self._times[-1]
            self._s1.predict(dt)
            self._s1.correct(value, it.s1_noise**2)
            h = share(dt, it.lag_time_constant)
            lagged = (1.0 - h) * self._lagged[-1] + h * float(self._s1.x[0])
            self._predict_bias(time_s)
        self._times.append(time_s)
        self._lagged.append(lagged)

    def _predict_bias(self, time_s: float) -> None:
        self._bias.predict(time_s - self._bias_s)
        self._bias_s = max(self._bias_s, time_s)
