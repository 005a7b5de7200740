# SPDX-License-Identifier: Apache-2.0
"""A node's clocks: the one of stamps, and one for ages and periods that never jumps."""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.clock import Clock, JumpHandle, JumpThreshold, ROSClock, TimeJump
from rclpy.clock_type import ClockType
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.timer import Timer


class NodeTime:
    """The time of a node.

    Attributes:
        simulated: Whether the node's clock follows /clock; kept, since asking costs time.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = node.get_clock()
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        threshold = JumpThreshold(min_forward=None, min_backward=None, on_clock_change=True)
        self._changes = self._clock.create_jump_callback(threshold, post_callback=self._on_change)
        self._on_change(None)

    def _on_change(self, _: TimeJump | None) -> None:
        self.simulated = isinstance(self._clock, ROSClock) and self._clock.ros_time_is_active

    def now_ns(self) -> int:
        """Return the time that stamps are of, nanoseconds; 0 while /clock has not come."""
        if not self.simulated:
            return time.time_ns()  # what the clock would say, at a tenth of the cost
        return int(self._clock.now().nanoseconds)

    def age_ns(self) -> int:
        """Return a time to measure ages by: simulated, so that a pause ages nothing, or steady."""
        return self.now_ns() if self.simulated else time.monotonic_ns()

    def every(self, period: float, callback: Callable[[], None]) -> Timer:
        """Call back every ``period`` seconds, whatever the node's clock does (rclpy #1490)."""
        return self._node.create_timer(period, callback, clock=self._steady)

    def on_jump_back(self, callback: Callable[[int], None]) -> JumpHandle:
        """Call back after /clock has jumped back, or has taken over or left.

        The callback takes how far it jumped back, nanoseconds; 0 where that means nothing.
        """

        def after(jump: TimeJump) -> None:
            callback(max(-int(jump.delta.nanoseconds), 0))

        threshold = JumpThreshold(min_forward=None, min_backward=Duration(nanoseconds=-1))
        return self._clock.create_jump_callback(threshold, post_callback=after)
