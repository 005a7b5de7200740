# SPDX-License-Identifier: Apache-2.0
"""The ticks of the timer trigger on a bag's log clock."""

from __future__ import annotations

from fuzzy_fusion_ros.parameters.fusion import Parameters


class Ticks:
    """A timer that begins with the first message; silent for every trigger but ``timer``."""

    def __init__(self, parameters: Parameters) -> None:
        self._period_ns = round(1e9 / parameters.rate) if parameters.trigger == "timer" else 0
        self._next_ns: int | None = None

    def due(self, log_ns: int) -> int | None:
        """Return when the first tick was due by ``log_ns``, and go on to those after it.

        Between two messages only the first tick has anything to do.
        """
        if self._period_ns == 0:
            return None
        if self._next_ns is None:
            self._next_ns = log_ns + self._period_ns
        if log_ns < self._next_ns:
            return None
        due_ns = self._next_ns
        self._next_ns += (log_ns - due_ns) // self._period_ns * self._period_ns + self._period_ns
        return due_ns
