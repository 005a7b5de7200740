# SPDX-License-Identifier: Apache-2.0
"""A run of the benchmark that waits after each sample for what the controller is to act on."""

from __future__ import annotations

import numpy as np

from fuzzy_fusion_ros.core.aggregator import blend
from fuzzy_fusion_ros.nodes.parameters import PendulumParameters
from fuzzy_fusion_ros.simulation.closed_loop import Reading, act, at_start, sense
from fuzzy_fusion_ros.simulation.pendulum import Pendulum
from fuzzy_fusion_ros.simulation.scenario import START_NS, samples_in, stamp_of
from fuzzy_fusion_ros.simulation.sensors import draw_noise


class SteppedRun:
    """The closed loop of :func:`fuzzy_fusion_ros.simulation.closed_loop.simulate`, opened.

    Attributes:
        stamp_ns: Stamp of the current sample, nanoseconds.
        reading: The sensors' readings of it; ``None`` before the first and after the last.
    """

    def __init__(self, parameters: PendulumParameters) -> None:
        self._parameters = parameters
        self._loop = at_start(parameters)
        self._samples = samples_in(parameters)
        self._noise = draw_noise(np.random.default_rng(parameters.seed), self._samples)
        self._step_ns = round(parameters.sample_time * 1e9)
        self._offset_ns = 0
        self.stamp_ns = 0
        self.reading: Reading | None = None

    @property
    def plant(self) -> Pendulum:
        """The pendulum at the current sample."""
        return self._loop.plant

    @property
    def samples(self) -> int:
        """Samples acted on so far."""
        return self._loop.k

    @property
    def fallen(self) -> bool:
        """Whether the pendulum has fallen."""
        return self._loop.fallen

    def start_at(self, stamp_ns: int) -> None:
        """Give the first sample another stamp."""
        self._offset_ns = stamp_ns - START_NS

    def skip(self, time_ns: int) -> None:
        """Stamp the samples from the next one on later by so much, nanoseconds."""
        self._offset_ns += time_ns

    def sense(self) -> Reading | None:
        """Take the next sample; ``None`` when the run is over."""
        k = self._loop.k
        if k >= self._samples or self._loop.fallen:
            self.reading = None
            return None
        self.stamp_ns = self._offset_ns + stamp_of(self._step_ns, k)
        self.reading = sense(self._parameters, self._loop, *self._noise[k].tolist())
        return self.reading

    def act(self, estimate: float) -> float:
        """Control on an estimate in rad, and go on to the next sample; return the force in N."""
        force, self._loop = act(self._parameters, self._loop, estimate)
        return force

    def feedback(self, name: str, estimate: float | None) -> float | None:
        """Return what the controller is to act on, in rad; ``None`` if it is not there yet.

        Args:
            name: One of :data:`fuzzy_fusion_ros.nodes.parameters.FEEDBACKS`.
            estimate: The newest estimate, rad.
        """
        if name == "estimate" or self.reading is None:
            return estimate
        if name == "average":
            return blend(0.5, self.reading.s1, self.reading.s2)
        return {"s1": self.reading.s1, "s2": self.reading.s2, "truth": self.plant.angle}[name]
