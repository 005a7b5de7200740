# SPDX-License-Identifier: Apache-2.0
"""The benchmark as a node: plant, sensors and controller, balanced on what comes back."""

from __future__ import annotations

import time
from typing import Any

from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from fuzzy_fusion_ros.messages import InstalledTypes, ScalarCodec
from fuzzy_fusion_ros.messages.outputs import POINT
from fuzzy_fusion_ros.nodes.parameters import PendulumParameters
from fuzzy_fusion_ros.nodes.plant_topics import PlantTopics
from fuzzy_fusion_ros.nodes.stepped_run import SteppedRun
from fuzzy_fusion_ros.parameters.errors import FusionError
from fuzzy_fusion_ros.ros.node import ConfiguredNode
from fuzzy_fusion_ros.ros.peers import Peers, Source
from fuzzy_fusion_ros.ros.qos import ESTIMATE
from fuzzy_fusion_ros.ros.recorder import recorder_for

FREE_RUN = 1e-4
"""Seconds between samples of a run that waits for nobody."""

WATCH = 0.02
"""Seconds between looks at the peers."""

STALL_NS = 100_000_000
"""Stamps of a paced run that fall this far behind the clock skip to it, nanoseconds."""


class PeerError(FusionError):
    """The other end of the loop is missing or silent."""


class PendulumNode(ConfiguredNode[PendulumParameters]):
    """Publishes ``s1``, ``s2`` and the truth, and controls on ``estimate``.

    In lockstep each sample waits for the estimate with its stamp. Paced, samples follow the
    clock and the newest estimate holds; while the machine is too busy, the plant stands still.
    """

    def __init__(self, **options: Any) -> None:
        """Make the node; ``options`` as :class:`ConfiguredNode` takes them.

        Raises:
            FusionError: A parameter or the bag directory cannot be used.
        """
        super().__init__("pendulum_node", PendulumParameters(), fixed=True, **options)

    def set_up(self) -> None:
        """Create topics, and begin to watch for peers."""
        self._lockstep = self.parameters.real_time_factor == 0.0
        self._follows_clock = not self._lockstep and not self.parameters.publish_clock
        self._needs_estimate = self.parameters.feedback == "estimate"
        self._run = SteppedRun(self.parameters)
        self._estimate: float | None = None
        self.recorder = recorder_for(self.parameters.record)
        self._topics = PlantTopics(self, self.recorder, clock=self.parameters.publish_clock)
        self._codec = ScalarCodec(InstalledTypes(), POINT)
        self._source = Source(self, "estimate", POINT, self.guarded(self._on_estimate))
        self.recorder.add(self._source.topic, POINT, ESTIMATE)
        self._peers = Peers(self, (self._topics.s1, self._topics.s2), self._source)
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._heard = time.monotonic()
        self._watch = self.create_timer(WATCH, self.guarded(self._on_watch), clock=self._steady)

    def _on_watch(self) -> None:
        """Start once all peers are there; end if they, or their estimates, do not come."""
        started = self._run.reading is not None
        if not started and (not self._needs_estimate or self._peers.ready(time.monotonic())):
            self._start()
        elif not started:
            self._refuse_silence(", ".join(self._peers.missing()))
        elif self._needs_estimate:
            self._refuse_silence(f"no estimate for the sample stamped {self._run.stamp_ns} ns")

    def _refuse_silence(self, problem: str) -> None:
        if time.monotonic() - self._heard > self.parameters.timeout:
            raise PeerError(
                f"{problem} within {self.parameters.timeout:g} s: start fusion_node so that it "
                f"subscribes to {self._topics.s1.topic} and {self._topics.s2.topic} and publishes "
                f"{self._source.topic}"
            )

    def _start(self) -> None:
        self._heard = time.monotonic()
        if self._follows_clock:
            self._run.start_at(self.get_clock().now().nanoseconds)
        self._sense()
        if not (self._lockstep and self._needs_estimate):
            factor = self.parameters.real_time_factor
            period = FREE_RUN if self._lockstep else self.parameters.sample_time / factor
            self._pace = self.create_timer(period, self.guarded(self._on_pace), clock=self._steady)

    def _on_estimate(self, data: bytes) -> None:
        if self._run.reading is None:
            return
        self.recorder.write(self._source.topic, self._run.stamp_ns, data)
        self._heard = time.monotonic()
        estimate = self._codec.sample(data, 0)
        self._estimate = estimate.value
        current = estimate.stamp_ns == self._run.stamp_ns
        if self._lockstep and self._needs_estimate and current:
            self._act(estimate.value)
            self._sense()

    def _on_pace(self) -> None:
        feedback = self._run.feedback(self.parameters.feedback, self._estimate)
        if self._run.reading is not None and feedback is not None:
            self._act(feedback)
            self._keep_up()
            self._sense()

    def _keep_up(self) -> None:
        """Let no missed timer ticks add up, as the stamps would age by each of them for ever."""
        behind_ns = self.get_clock().now().nanoseconds - self._run.stamp_ns
        if self._follows_clock and self.parameters.real_time_factor == 1.0 and behind_ns > STALL_NS:
            self._run.skip(behind_ns)

    def _act(self, feedback: float) -> None:
        stamp_ns = self._run.stamp_ns
        self._topics.send_control(stamp_ns, self._run.act(feedback))

    def _sense(self) -> None:
        reading = self._run.sense()
        if reading is None:
            self._finish()
        else:
            self._topics.send_sample(self._run.stamp_ns, self._run.plant, reading)

    def _finish(self) -> None:
        self._watch.cancel()
        seconds = self._run.samples * self.parameters.sample_time
        if self._run.fallen:
            self.log.warning(f"the pendulum fell after {seconds:g} s")
        else:
            self.log.info(f"the pendulum was balanced for {seconds:g} s")
        self._topics.flush(1.0)
        self.finished = True
