# SPDX-License-Identifier: Apache-2.0
"""Sends samples to one process under measurement, and takes what it gives back."""

from __future__ import annotations

import math
import statistics
import time
from collections import deque
from typing import NamedTuple

from geometry_msgs.msg import PointStamped
from rclpy.qos import QoSProfile

from bench.child import Child
from bench.graph import Graph
from bench.wire import age_of, sample

S2_EVERY = 10
"""A sample of S2 goes out before every tenth of S1."""

WINDOW = 4
"""Samples under way at saturation: what a best-effort subscription of depth 5 holds."""

TAIL = 0.1
"""Seconds to wait for the last answers of a burst."""

STALL = 0.05
"""Seconds without an answer after which a message counts as lost."""


class Burst(NamedTuple):
    """What a burst of samples has cost.

    Attributes:
        cpu: CPU time of the process per answer, seconds.
        median: Median time from sample to answer, seconds.
        p99: 99th percentile of it, seconds.
        lost: Share of samples without an answer.
    """

    cpu: float
    median: float
    p99: float
    lost: float


class Channel:
    """Both directions to one process."""

    def __init__(
        self,
        graph: Graph,
        child: Child,
        namespace: str,
        answers: str | None = None,
        *,
        listeners: int = 1,
    ) -> None:
        """Open both directions.

        Args:
            graph: The measuring end.
            child: The process.
            namespace: That of its topics ``s1`` and ``s2``.
            answers: That of ``estimate``, if it is another one.
            listeners: How many processes listen to ``s1`` and ``s2``.
        """
        self._graph = graph
        self._child = child
        self._listeners = listeners
        profile = QoSProfile(depth=1000)
        self._s1 = graph.node.create_publisher(PointStamped, f"{namespace}/s1", profile)
        self._s2 = graph.node.create_publisher(PointStamped, f"{namespace}/s2", profile)
        self._ages: deque[float] = deque()
        self._answers = graph.node.create_subscription(
            PointStamped, f"{answers or namespace}/estimate", self._on_answer, profile, raw=True
        )
        self._sent = 0

    @property
    def matched(self) -> bool:
        """Whether all connections are there."""
        return (
            self._s1.get_subscription_count() >= self._listeners
            and self._s2.get_subscription_count() >= self._listeners
            and self._answers.get_publisher_count() > 0
        )

    def warm_up(self) -> None:
        """Send samples until answers come."""
        self._graph.spin_until(lambda: self.matched)
        self._ages.clear()
        while len(self._ages) < 20:
            self.send()
            self._graph.spin_to(time.monotonic() + 0.01)

    def send(self) -> None:
        """Send a sample, stamped now."""
        swing = 0.3 * math.sin(0.05 * self._sent)
        stamp_ns = time.time_ns()
        if self._sent % S2_EVERY == 0:
            self._s2.publish(sample(stamp_ns, swing))
        noise = 0.05 * math.sin(1.7 * self._sent * self._sent)
        self._s1.publish(sample(stamp_ns, swing + noise))
        self._sent += 1

    def burst(self, rate: float, seconds: float) -> Burst:
        """Send samples at a rate, Hz."""
        self.warm_up()
        self._ages.clear()
        cpu = self._child.cpu
        begin = time.monotonic()
        samples = round(rate * seconds)
        for k in range(samples):
            self._graph.spin_to(begin + k / rate)
            self.send()
        self._graph.spin_to(time.monotonic() + TAIL)
        ages = sorted(self._ages)
        cost = self._child.cpu - cpu
        return Burst(
            cpu=cost / max(len(ages), 1),
            median=statistics.median(ages),
            p99=ages[math.ceil(0.99 * len(ages)) - 1],
            lost=1.0 - len(ages) / samples,
        )

    def saturate(self, seconds: float) -> tuple[float, float]:
        """Keep some samples under way; return answers per second, and per second of its CPU."""
        self.warm_up()
        self._ages.clear()
        cpu = self._child.cpu
        begin = heard = time.monotonic()
        for _ in range(WINDOW):
            self.send()
        answers = 0
        while (now := time.monotonic()) < begin + seconds:
            self._graph.executor.spin_once(timeout_sec=STALL)
            new = len(self._ages) - answers
            if new:
                heard = now
                answers += new
            elif now - heard > STALL:
                heard, new = now, WINDOW
            for _ in range(new):
                self.send()
        used = self._child.cpu - cpu
        self._graph.spin_to(time.monotonic() + TAIL)
        return answers / (now - begin), answers / used

    def _on_answer(self, data: bytes) -> None:
        self._ages.append(age_of(data))
