# SPDX-License-Identifier: Apache-2.0
"""Kalman filters of filterpy over the two random walks, in matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


class RandomWalks:
    """The signal, and S1's bias if ``bias_noise`` is not ``None``; starts at the first S2."""

    def __init__(
        self,
        process_noise: float,
        s1_noise: float,
        s2_noise: float,
        bias_noise: float | None,
    ) -> None:
        # Takes 2 s, in every process that collects the tests.
        from filterpy.kalman import KalmanFilter

        size = 1 if bias_noise is None else 2
        self._rates = np.diag([process_noise**2, (bias_noise or 0.0) ** 2][:size])
        self._s1 = np.ones((1, size)), s1_noise**2
        self._s2 = np.eye(1, size), s2_noise**2
        self._filter = KalmanFilter(dim_x=size, dim_z=1)
        self._filter.F = np.eye(size)
        self._known = 0
        self._time_s = 0.0

    @property
    def signal(self) -> float:
        """Mean of the signal."""
        return float(self._filter.x[0, 0])

    @property
    def variance(self) -> float:
        """Variance of the signal."""
        return float(self._filter.P[0, 0])

    def take_s2(self, time_s: float, value: float) -> None:
        """Take a sample of S2."""
        if self._known == 0:
            self._filter.x[0, 0] = value
            self._filter.P = np.zeros_like(self._filter.P)
            self._filter.P[0, 0] = self._s2[1]
            self._known, self._time_s = 1, time_s
            return
        self._take(time_s, value, *self._s2)

    def take_s1(self, time_s: float, value: float) -> None:
        """Take a sample of S1, the first of which tells the bias."""
        if self._known < len(self._filter.x):
            self._predict(time_s)
            at, spread = self._filter.x, self._filter.P
            at[1, 0] = value - at[0, 0]
            spread[0, 1] = spread[1, 0] = -spread[0, 0]
            spread[1, 1] = spread[0, 0] + self._s1[1]
            self._known = 2
            return
        self._take(time_s, value, *self._s1)

    def _take(
        self, time_s: float, value: float, model: NDArray[np.float64], variance: float
    ) -> None:
        self._predict(time_s)
        self._filter.update(np.array([[value]]), R=np.array([[variance]]), H=model)

    def _predict(self, time_s: float) -> None:
        self._filter.predict(Q=self._rates * max(time_s - self._time_s, 0.0))
        self._time_s = max(self._time_s, time_s)
